#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/concepts.hpp"
#include "gmis/core/square_table.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

/// Light or importance that a training subpath brought to a surface point: a light subpath brings
/// light, which guides camera subpaths (`mode` radiance); a camera subpath brings importance, which
/// guides light subpaths (`mode` importance).
template <std::floating_point T>
struct Incidence {
  Vec3<T> position;    ///< of the surface point
  Vec3<T> normal;      ///< the shading normal there
  Vec3<T> direction;   ///< unit, to where it comes from
  T mass;              ///< flux, or importance
  TransportMode mode;  ///< of the subpaths that are to be guided
};

/// A part of the surfaces with one dominant axis of the normal, and where light and importance come
/// from there: tables over the hemisphere around that axis.
template <std::floating_point T>
struct GuideCell {
  /// Over the octahedral map of a hemisphere.
  using Table = SquareTable<T>;
  int axis = 0;                          ///< of the hemispheres: 0 to 2
  T sign = T(1);                         ///< of that coordinate of the normal
  std::array<const Table*, 4> tables{};  ///< by `place`; null: nothing is learned

  /// The place in `tables` for a side of the surface and a mode.
  [[nodiscard]] static constexpr std::size_t place(bool is_front, TransportMode mode) noexcept {
    return (is_front ? 0U : 1U) + (mode == TransportMode::radiance ? 0U : 2U);
  }
  /// The direction in coordinates whose third is along the axis, on the side that `is_front` says.
  [[nodiscard]] Vec3<T> to_local(bool is_front, const Vec3<T>& world) const noexcept {
    return {world[(axis + 1) % 3], world[(axis + 2) % 3], (is_front ? sign : -sign) * world[axis]};
  }
  /// The inverse of `to_local`.
  [[nodiscard]] Vec3<T> to_world(bool is_front, const Vec3<T>& local) const noexcept {
    Vec3<T> world;
    world[(axis + 1) % 3] = local.x;
    world[(axis + 2) % 3] = local.y;
    world[axis] = (is_front ? sign : -sign) * local.z;
    return world;
  }
};

/// The lobe of a cell of a `DirectionGuide`: models `DirectionLobe`.
template <std::floating_point T>
class LearnedLobe {
 public:
  LearnedLobe() = default;
  /// Probability of sampling the learned lobe where there is one.
  static constexpr T learned_share = T(0.5);

  /// `cell` must outlive this; null for no lobe.
  explicit LearnedLobe(const GuideCell<T>* cell) noexcept : cell_(cell) {}

  /// True for no lobe.
  [[nodiscard]] bool is_empty() const noexcept { return cell_ == nullptr; }
  /// `learned_share` where a table was learned for this side and mode, else 0.
  [[nodiscard]] T share(bool is_front, TransportMode mode) const noexcept {
    return table(is_front, mode) != nullptr ? learned_share : T(0);
  }
  /// A unit direction on the hemisphere around the axis of the cell, in the world frame.
  [[nodiscard]] Vec3<T> sample(bool is_front, const Vec2<T>& uv, TransportMode mode) const noexcept {
    return cell_->to_world(is_front, square_to_octahedral_hemisphere(table(is_front, mode)->warp(uv).point));
  }
  /// Per steradian; 0 beyond that hemisphere.
  [[nodiscard]] T pdf(bool is_front, const Vec3<T>& to_next, TransportMode mode) const noexcept {
    const Vec3<T> local = cell_->to_local(is_front, to_next);
    if (!(local.z > T(0))) return T(0);
    const Vec2<T> point = octahedral_hemisphere_to_square(local);
    return table(is_front, mode)->density(point) * octahedral_hemisphere_density(local);
  }

 private:
  [[nodiscard]] const SquareTable<T>* table(bool is_front, TransportMode mode) const noexcept {
    return cell_->tables[GuideCell<T>::place(is_front, mode)];
  }
  const GuideCell<T>* cell_ = nullptr;
};

/// Where light and importance come from, by cells of the surfaces: a k-d tree over positions for
/// each dominant axis of the normal. Made of incidences, and frozen from then on.
template <std::floating_point T>
class DirectionGuide {
 public:
  /// The lobe that `lobe_at` returns.
  using Lobe = LearnedLobe<T>;
  /// A part of the surfaces.
  using Cell = GuideCell<T>;

  /// A cell is divided when the mode with fewer incidences has more than this number; if that mode
  /// has too few for a table, the other one counts.
  static constexpr std::size_t most_incidences = 512;
  /// A table of fewer incidences is not made: the BSDF keeps its own sampling.
  static constexpr std::size_t least_incidences = 64;

  /// Guides nothing.
  DirectionGuide() = default;
  /// The result depends on the order of the incidences alone.
  explicit DirectionGuide(std::vector<Incidence<T>> incidences) {
    const auto face = [](const Incidence<T>& incidence) { return face_of(incidence.normal); };
    std::stable_sort(incidences.begin(), incidences.end(),
                     [&](const auto& a, const auto& b) { return face(a) < face(b); });
    auto begin = incidences.begin();
    for (std::size_t i = 0; i < faces; ++i) {
      const auto end = std::find_if(begin, incidences.end(), [&](const auto& a) { return face(a) != i; });
      roots_[i] = static_cast<std::uint32_t>(nodes_.size());
      nodes_.emplace_back();
      build(roots_[i], i, {begin, end}, 0);
      begin = end;
    }
    // The tables stay where they are from here on.
    for (std::size_t i = 0; i < cells_.size(); ++i)
      for (std::size_t place = 0; place < 4; ++place)
        if (places_[i][place] != none) cells_[i].tables[place] = &tables_[places_[i][place]];
    places_.clear();
  }
  DirectionGuide(const DirectionGuide&) = delete;
  DirectionGuide& operator=(const DirectionGuide&) = delete;
  /// Lobes stay valid.
  DirectionGuide(DirectionGuide&&) noexcept = default;
  /// Lobes stay valid.
  DirectionGuide& operator=(DirectionGuide&&) noexcept = default;
  ~DirectionGuide() = default;

  /// The lobe at a surface point; empty where `is_guidable` is false or nothing was learned.
  template <Bsdf B>
  [[nodiscard]] Lobe lobe_at(const SurfacePoint<T>& point, const B& bsdf) const noexcept {
    if (nodes_.empty() || !is_guidable(bsdf)) return {};
    const Node* node = &nodes_[roots_[face_of(point.shading_normal)]];
    while (node->axis < 3) node = &nodes_[node->link + (point.position[node->axis] < node->split ? 0U : 1U)];
    return node->link == none ? Lobe() : Lobe(&cells_[node->link]);
  }
  /// Whether surfaces with this BSDF are guided: it is not purely delta and reports no narrow lobe,
  /// which guided directions would miss.
  template <Bsdf B>
  [[nodiscard]] static constexpr bool is_guidable(const B& bsdf) noexcept {
    if constexpr (BsdfWithNarrowLobes<B>)
      if (bsdf.has_narrow_lobe()) return false;
    return !bsdf.is_purely_delta();
  }

  /// All cells, in an order that depends on the incidences alone.
  [[nodiscard]] std::span<const Cell> cells() const noexcept { return cells_; }
  /// Bytes held.
  [[nodiscard]] std::size_t byte_count() const noexcept {
    return nodes_.capacity() * sizeof(Node) + cells_.capacity() * sizeof(Cell) +
           tables_.capacity() * sizeof(SquareTable<T>);
  }

 private:
  static constexpr std::size_t faces = 6;
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  struct Node {
    T split{};
    std::uint8_t axis = 3;      ///< 3: a leaf
    std::uint32_t link = none;  ///< the first of two children, or the cell
  };
  using Incidences = std::span<Incidence<T>>;

  /// The signed axis nearest to a normal.
  [[nodiscard]] static std::size_t face_of(const Vec3<T>& normal) noexcept {
    const Vec3<T> size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return static_cast<std::size_t>(2 * axis + (normal[axis] < T(0) ? 1 : 0));
  }

  [[nodiscard]] static std::size_t scarcer_count(Incidences of) noexcept {
    const auto light = static_cast<std::size_t>(std::count_if(
        of.begin(), of.end(), [](const auto& incidence) { return incidence.mode == TransportMode::radiance; }));
    const std::size_t importance = of.size() - light, fewer = std::min(light, importance);
    return fewer < least_incidences ? std::max(light, importance) : fewer;
  }

  void build(std::uint32_t at, std::size_t face, Incidences of, int depth) {
    constexpr int deepest = 24;
    if (scarcer_count(of) > most_incidences && depth < deepest) {
      Vec3<T> lower = of.front().position, upper = lower;
      for (const auto& incidence : of) {
        lower = glm::min(lower, incidence.position);
        upper = glm::max(upper, incidence.position);
      }
      const Vec3<T> size = upper - lower;
      const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
      const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
      std::nth_element(of.begin(), middle, of.end(),
                       [=](const auto& a, const auto& b) { return a.position[axis] < b.position[axis]; });
      const T split = middle->position[axis];
      if (lower[axis] < split) {
        const auto children = static_cast<std::uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + 2);
        nodes_[at] = {split, static_cast<std::uint8_t>(axis), children};
        build(children, face, {of.begin(), middle}, depth + 1);
        build(children + 1, face, {middle, of.end()}, depth + 1);
        return;
      }
    }
    make_cell(at, face, of);
  }

  void make_cell(std::uint32_t at, std::size_t face, Incidences of) {
    using Table = SquareTable<T>;
    Cell cell;
    cell.axis = static_cast<int>(face / 2);
    cell.sign = face % 2 == 0 ? T(1) : T(-1);
    std::array<std::array<double, Table::size>, 4> masses{};
    std::array<std::size_t, 4> counts{};
    for (const auto& incidence : of) {
      const bool is_front = glm::dot(incidence.normal, incidence.direction) > T(0);
      const Vec3<T> local = cell.to_local(is_front, incidence.direction);
      if (!(local.z > T(0))) continue;
      const std::size_t place = Cell::place(is_front, incidence.mode);
      masses[place][Table::bin_of(octahedral_hemisphere_to_square(local))] += static_cast<double>(incidence.mass);
      ++counts[place];
    }
    std::array<std::uint32_t, 4> places{none, none, none, none};
    for (std::size_t place = 0; place < 4; ++place) {
      if (counts[place] < least_incidences) continue;
      places[place] = static_cast<std::uint32_t>(tables_.size());
      tables_.emplace_back(Table::smoothed(masses[place]), 0.02);
    }
    if (places == std::array{none, none, none, none}) return;
    nodes_[at].link = static_cast<std::uint32_t>(cells_.size());
    cells_.push_back(cell);
    places_.push_back(places);
  }

  std::array<std::uint32_t, faces> roots_{};
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  std::vector<SquareTable<T>> tables_;
  std::vector<std::array<std::uint32_t, 4>> places_;  ///< of the tables of each cell, while they are made
};

}  // namespace gmis
