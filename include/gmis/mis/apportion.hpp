#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "gmis/core/argument_error.hpp"

namespace gmis {

/// Splits `total` samples among proposals in proportion to `weights` (non-negative, finite, not all
/// zero) by the method of largest remainders; ties go to the lower index. The counts sum to
/// `total`, and each differs from its exact quota by less than one. A pure function, so that every
/// path vertex of one kind gets the same counts.
///
/// Throws std::invalid_argument for other weights, when `counts` and `weights` differ in size, and
/// for 2^32 samples or more.
template <std::floating_point T>
constexpr void apportion(std::span<const T> weights, std::size_t total, std::span<std::uint32_t> counts) {
  using Q =
      std::conditional_t<(sizeof(T) < sizeof(double)), double, T>;  // of any total below 2^32, a quota is exact enough
  T largest(0);
  for (const T weight : weights) {
    require_argument(weight >= T(0) && weight <= std::numeric_limits<T>::max(),
                     "a weight is negative or not finite: weights are non-negative numbers");
    largest = std::max(largest, weight);
  }
  require_argument(largest > T(0),
                   "all weights are zero, or there are none: give at least one proposal a positive weight");
  require_argument(counts.size() == weights.size(), "the numbers of weights and counts differ");
  require_argument(total <= std::numeric_limits<std::uint32_t>::max(), "a round of 2^32 samples or more");
  Q sum(0);
  for (const T weight : weights) sum += static_cast<Q>(weight) / static_cast<Q>(largest);
  const auto quota = [&](std::size_t i) {
    return static_cast<Q>(weights[i]) / static_cast<Q>(largest) / sum * static_cast<Q>(total);
  };
  std::size_t given = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    counts[i] = static_cast<std::uint32_t>(quota(i));
    given += counts[i];
  }
  while (given != total) {
    // Rounding can hand out one too many as well as too few; both are put right where the quota is
    // missed the most.
    const bool too_few = given < total;
    std::size_t worst = 0;
    Q worst_error(-2);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const Q shortfall = quota(i) - static_cast<Q>(counts[i]);
      const Q error = too_few ? shortfall : -shortfall;
      const bool can_change = too_few ? weights[i] > T(0) : counts[i] > 0;
      if (can_change && error > worst_error) {
        worst = i;
        worst_error = error;
      }
    }
    counts[worst] += too_few ? 1U : ~0U;
    given += too_few ? std::size_t{1} : ~std::size_t{0};
  }
}

/// `apportion`, but every positive weight gets at least one sample: a proposal without any would
/// leave a hole where it alone is positive. The others pay for it, those furthest above their quota
/// first. Where the quotas of all positive weights are one or more, this is `apportion`. Throws as
/// `apportion` does, and when there are fewer samples than positive weights.
template <std::floating_point T>
constexpr void apportion_to_all(std::span<const T> weights, std::size_t total, std::span<std::uint32_t> counts) {
  apportion(weights, total, counts);
  using Q = std::conditional_t<(sizeof(T) < sizeof(double)), double, T>;
  const T largest = *std::max_element(weights.begin(), weights.end());
  Q sum(0);
  std::size_t positive = 0;
  for (const T weight : weights) {
    sum += static_cast<Q>(weight) / static_cast<Q>(largest);
    if (weight > T(0)) ++positive;
  }
  require_argument(total >= positive, "fewer samples than positive weights: ask for at least one sample for each");
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (counts[i] > 0 || !(weights[i] > T(0))) continue;
    counts[i] = 1;
    std::size_t payer = i;
    Q most(0);
    for (std::size_t other = 0; other < weights.size(); ++other) {
      const Q surplus = static_cast<Q>(counts[other]) -
                        static_cast<Q>(weights[other]) / static_cast<Q>(largest) / sum * static_cast<Q>(total);
      if (counts[other] > 1 && (payer == i || surplus > most)) {
        payer = other;
        most = surplus;
      }
    }
    --counts[payer];
  }
}

}  // namespace gmis
