#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Draws an index with probability proportional to a weight, in constant time [Walker 1974, Vose 1991].
template <std::floating_point T>
class AliasTable {
 public:
  AliasTable() = default;

  /// Weights finite and not negative. The table is empty when none is positive.
  explicit AliasTable(std::span<const double> weights) {
    double sum = 0;
    for (const double weight : weights) sum += weight;
    if (!(sum > 0)) return;
    const std::size_t count = weights.size();
    cells_.resize(count);
    std::vector<double> height(count);
    std::vector<std::size_t> small, large;
    for (std::size_t i = 0; i < count; ++i) {
      height[i] = weights[i] / sum * static_cast<double>(count);
      (height[i] < 1 ? small : large).push_back(i);
      cells_[i] = {T(1), static_cast<std::uint32_t>(i)};
    }
    while (!small.empty() && !large.empty()) {
      const std::size_t low = small.back();
      const std::size_t high = large.back();
      small.pop_back();
      cells_[low] = {static_cast<T>(height[low]), static_cast<std::uint32_t>(high)};
      height[high] -= 1 - height[low];
      if (height[high] < 1) {
        large.pop_back();
        small.push_back(high);
      }
    }
    // What is left has height 1 but for rounding; an index of weight 0 must not be among it.
    for (const std::size_t i : small)
      if (weights[i] == 0) cells_[i] = {T(0), static_cast<std::uint32_t>(heaviest(weights))};
  }

  [[nodiscard]] bool is_empty() const noexcept { return cells_.empty(); }

  /// `u` in [0, 1). The table must not be empty.
  [[nodiscard]] std::size_t sample(T u) const noexcept {
    const T scaled = u * static_cast<T>(cells_.size());
    const std::size_t cell = std::min(static_cast<std::size_t>(scaled), cells_.size() - 1);
    return scaled - static_cast<T>(cell) < cells_[cell].threshold ? cell : cells_[cell].alias;
  }

  struct Choice {
    std::size_t index;
    T rest;  ///< in [0, 1), as uniform as `u` was and independent of `index`, with as many digits as are left
  };
  /// As `sample`, and what of `u` was not needed.
  [[nodiscard]] Choice sample_and_reuse(T u) const noexcept {
    const T scaled = u * static_cast<T>(cells_.size());
    const std::size_t i = std::min(static_cast<std::size_t>(scaled), cells_.size() - 1);
    constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);
    const T place = std::min(scaled - static_cast<T>(i), below_one);
    const Cell& cell = cells_[i];
    const bool is_own = place < cell.threshold;
    const T rest = is_own ? place / cell.threshold : (place - cell.threshold) / (T(1) - cell.threshold);
    return {is_own ? i : cell.alias, std::min(rest, below_one)};
  }

  /// The probability that the cells give to `index`, to check them by: takes time linear in their number.
  [[nodiscard]] double probability(std::size_t index) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (i == index) sum += static_cast<double>(cells_[i].threshold);
      if (cells_[i].alias == index) sum += 1 - static_cast<double>(cells_[i].threshold);
    }
    return sum / static_cast<double>(cells_.size());
  }

 private:
  struct Cell {
    T threshold;
    std::uint32_t alias;
  };

  [[nodiscard]] static std::size_t heaviest(std::span<const double> weights) noexcept {
    std::size_t best = 0;
    for (std::size_t i = 1; i < weights.size(); ++i)
      if (weights[i] > weights[best]) best = i;
    return best;
  }

  std::vector<Cell> cells_;
};

}  // namespace gmis::scene
