#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Draws an index with a probability proportional to its weight, in constant time [Walker 1974,
/// Vose 1991].
template <std::floating_point T>
class AliasTable {
 public:
  AliasTable() = default;

  /// All weights must be finite and not negative. The table is empty when no weight is positive.
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
    // The remaining cells have height 1 up to rounding. A cell of weight 0 must never be drawn, so
    // its alias takes it whole.
    for (const std::size_t i : small)
      if (weights[i] == 0) cells_[i] = {T(0), static_cast<std::uint32_t>(heaviest(weights))};
  }

  [[nodiscard]] bool is_empty() const noexcept { return cells_.empty(); }

  /// An index drawn with `u` in [0, 1). The table must not be empty.
  [[nodiscard]] std::size_t sample(T u) const noexcept {
    const Place at = place_of(u);
    return at.height < cells_[at.cell].threshold ? at.cell : cells_[at.cell].alias;
  }

  struct Choice {
    std::size_t index;
    T rest;  ///< uniform in [0, 1) and independent of `index`; has the bits of `u` that the choice did not use
  };
  /// The index of `sample(u)`, and a new uniform number made from the unused part of `u`.
  [[nodiscard]] Choice sample_and_reuse(T u) const noexcept {
    constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);
    const Place at = place_of(u);
    const Cell& cell = cells_[at.cell];
    const T height = std::min(at.height, below_one);
    const bool is_own = height < cell.threshold;
    const T rest = is_own ? height / cell.threshold : (height - cell.threshold) / (T(1) - cell.threshold);
    return {is_own ? at.cell : cell.alias, std::min(rest, below_one)};
  }

  /// The exact probability of each index when `u` is uniform over the multiples of 2^-24 in [0, 1)
  /// (2^-53 in double precision). In a table with many cells, few values of `u` fall into each
  /// cell, and these probabilities differ from the weights. An estimator that divides by them is
  /// unbiased.
  [[nodiscard]] std::vector<double> realised_probabilities() const {
    constexpr std::uint64_t steps = std::uint64_t{1} << std::numeric_limits<T>::digits;
    // Bisection: the first value for which the monotone predicate `is_past` holds.
    const auto first = [](std::uint64_t lower, std::uint64_t upper, auto&& is_past) {
      while (lower < upper) {
        const std::uint64_t middle = lower + (upper - lower) / 2;
        if (is_past(static_cast<T>(middle) / static_cast<T>(steps)))
          upper = middle;
        else
          lower = middle + 1;
      }
      return lower;
    };
    std::vector<double> result(cells_.size());
    std::uint64_t begin = 0;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const std::uint64_t end = first(begin, steps, [&](T u) { return place_of(u).cell > cell; });
      const std::uint64_t turn = first(begin, end, [&](T u) { return !(place_of(u).height < cells_[cell].threshold); });
      result[cell] += static_cast<double>(turn - begin) / static_cast<double>(steps);
      result[cells_[cell].alias] += static_cast<double>(end - turn) / static_cast<double>(steps);
      begin = end;
    }
    return result;
  }

  /// The probability of `index` by the thresholds of all cells, for tests; takes time proportional
  /// to the number of cells.
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

  struct Place {
    std::size_t cell;
    T height;  ///< within the cell
  };
  [[nodiscard]] Place place_of(T u) const noexcept {
    const T scaled = u * static_cast<T>(cells_.size());
    const std::size_t cell = std::min(static_cast<std::size_t>(scaled), cells_.size() - 1);
    return {cell, scaled - static_cast<T>(cell)};
  }

  [[nodiscard]] static std::size_t heaviest(std::span<const double> weights) noexcept {
    std::size_t best = 0;
    for (std::size_t i = 1; i < weights.size(); ++i)
      if (weights[i] > weights[best]) best = i;
    return best;
  }

  std::vector<Cell> cells_;
};

}  // namespace gmis::scene
