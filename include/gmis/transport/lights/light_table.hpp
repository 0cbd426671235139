#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/transport/counts/vertex_cells.hpp"

namespace gmis {

/// What a light gave a vertex by one next event.
template <std::floating_point T, class L>
struct LightArrival {
  Vec3<T> position;          ///< of the vertex
  Vec3<T> normal;            ///< its geometric normal; of any length
  const L* light = nullptr;  ///< which light was chosen
  /// (contribution to the picture)² × probability of the choice: its mean over all choices is that of the squared contribution, were the light
  /// always chosen and the contribution not divided.
  double moment = 0.0;
};

/// For every cell of the surfaces the lights that reach it, with probabilities in proportion to √(second moment of their
/// contribution): with these the variance of a next event that chooses one light is least. It is frozen while it is used.
template <std::floating_point T, class L>
class LightTable {
 public:
  /// Largest share of the learned choice; the rest is the scene's own, so that no light loses its probability.
  static constexpr double most_share = 0.9;
  /// A cell with so many arrivals for each light that it has met has half of that share: with many lights many are still to be met.
  static constexpr double borrowed = 8.0;

  /// A light with its probability in a cell.
  struct Entry {
    const L* light;
    T probability;
    T below;  ///< sum of the probabilities of the entries before it
  };

  /// Knows nothing.
  LightTable() = default;
  /// Made from all arrivals, in their order.
  explicit LightTable(const std::vector<LightArrival<T, L>>& arrivals) {
    if (arrivals.empty()) return;
    std::vector<Vec3<T>> positions;
    for (const auto& arrival : arrivals) positions.push_back(arrival.position);
    cells_ = VertexCells<T>(positions);
    std::vector<std::uint32_t> order(arrivals.size()), cell_of(arrivals.size());
    for (std::size_t i = 0; i < arrivals.size(); ++i) {
      order[i] = static_cast<std::uint32_t>(i);
      cell_of[i] = static_cast<std::uint32_t>(cells_(arrivals[i].position, arrivals[i].normal));
    }
    // By cell, then by light; sums of one light are then made in the order of the arrivals.
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (cell_of[a] != cell_of[b]) return cell_of[a] < cell_of[b];
      return std::less<const L*>()(arrivals[a].light, arrivals[b].light);
    });
    first_.assign(VertexCells<T>::count + 1, 0);
    shares_.assign(VertexCells<T>::count, T(0));
    std::size_t at = 0;
    for (std::size_t cell = 0; cell < VertexCells<T>::count; ++cell) {
      first_[cell] = static_cast<std::uint32_t>(entries_.size());
      const std::size_t begin = at;
      double sum = 0.0;
      while (at < order.size() && cell_of[order[at]] == cell) {
        const L* const light = arrivals[order[at]].light;
        double moment = 0.0;
        for (; at < order.size() && cell_of[order[at]] == cell && arrivals[order[at]].light == light; ++at)
          moment += arrivals[order[at]].moment;
        if (!(moment > 0.0)) continue;
        entries_.push_back({light, static_cast<T>(std::sqrt(moment)), T(0)});
        sum += std::sqrt(moment);
      }
      if (!(sum > 0.0)) continue;
      double below = 0.0;
      for (std::size_t i = first_[cell]; i < entries_.size(); ++i) {
        const double probability = static_cast<double>(entries_[i].probability) / sum;
        entries_[i].below = static_cast<T>(below);
        entries_[i].probability = static_cast<T>(probability);
        below += probability;
      }
      const auto count = static_cast<double>(at - begin), lights = static_cast<double>(entries_.size() - first_[cell]);
      shares_[cell] = static_cast<T>(most_share * count / (count + borrowed * lights));
    }
    first_.back() = static_cast<std::uint32_t>(entries_.size());
  }

  /// True when it knows nothing.
  [[nodiscard]] bool is_empty() const noexcept { return entries_.empty(); }
  /// The cell of a vertex. Of a table that knows nothing all are the same.
  [[nodiscard]] std::size_t cell(const Vec3<T>& position, const Vec3<T>& normal) const noexcept {
    return is_empty() ? 0 : cells_(position, normal);
  }
  /// Share of the learned choice in a cell, in [0, `most_share`]; 0 where nothing was learned.
  [[nodiscard]] T share(std::size_t cell) const noexcept { return is_empty() ? T(0) : shares_[cell]; }
  /// A light of a cell that has a share. `u` is uniform in [0, 1).
  [[nodiscard]] const L* sample(std::size_t cell, T u) const noexcept {
    const auto begin = entries_.begin() + first_[cell], end = entries_.begin() + first_[cell + 1];
    // The last entry that begins at u or below. Those before it end there, so that its probability is what it says but for rounding.
    return std::prev(
               std::upper_bound(begin + 1, end, u, [](T value, const Entry& entry) { return value < entry.below; }))
        ->light;
  }
  /// The probability with which `sample` chooses a light; 0 for one that the cell does not have.
  [[nodiscard]] T probability(std::size_t cell, const L* light) const noexcept {
    if (is_empty()) return T(0);
    const auto begin = entries_.begin() + first_[cell], end = entries_.begin() + first_[cell + 1];
    const auto found = std::lower_bound(begin, end, light, [](const Entry& entry, const L* wanted) {
      return std::less<const L*>()(entry.light, wanted);
    });
    return found != end && found->light == light ? found->probability : T(0);
  }

 private:
  VertexCells<T> cells_;
  std::vector<Entry> entries_;        // by cell, and in a cell by address
  std::vector<std::uint32_t> first_;  // of each cell, its first entry
  std::vector<T> shares_;
};

}  // namespace gmis
