#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "gmis/core/argument_error.hpp"

/// \file
/// Weighting heuristics of the multi-sample form [Veach 1997, section 9.2], with counts: technique
/// i makes n_i samples of density p_i, so its expected sample density is d_i = n_i p_i. A heuristic
/// turns all d_i at one point into weights that sum to one. Densities may span the whole range of
/// T: they are only ever used relative to the largest.

namespace gmis {

/// w_i = d_i / Σ d. N3 and R3 are this one.
struct Balance {
  /// The weight of ratio r = d_i / max d, r in [0, 1], before normalisation.
  template <std::floating_point T>
  [[nodiscard]] static constexpr T unnormalised(T r) noexcept {
    return r;
  }
};

/// w_i = d_i^β / Σ d^β; β = 2 is the usual choice, β = 1 is Balance.
struct Power {
  double beta = 2.0;  ///< the exponent, at least 0

  /// r^β.
  template <std::floating_point T>
  [[nodiscard]] T unnormalised(T r) const noexcept {
    return beta == 2.0 ? r * r : std::pow(r, static_cast<T>(beta));
  }
};

/// Balance among the techniques with d_i ≥ threshold · max d, zero for the others; threshold in [0,
/// 1].
struct Cutoff {
  double threshold = 0.1;  ///< relative to the largest density

  /// r, or 0 below the threshold.
  template <std::floating_point T>
  [[nodiscard]] constexpr T unnormalised(T r) const noexcept {
    return r >= static_cast<T>(threshold) ? r : T(0);
  }
};

/// All weight to the technique with the largest d_i, shared equally among equals.
struct Maximum {
  /// 1 for the largest, else 0.
  template <std::floating_point T>
  [[nodiscard]] static constexpr T unnormalised(T r) noexcept {
    return r == T(1) ? T(1) : T(0);
  }
};

/// A function of d_i / max d alone, non-negative and positive at 1; the weights are its values over
/// their sum.
template <class H>
concept Heuristic = requires(const H& heuristic, double r) {
  { heuristic.unnormalised(r) } -> std::same_as<double>;
};

/// Throws std::invalid_argument for a heuristic that gives the largest density no weight, a smaller
/// one more weight than the largest, or any a negative weight or NaN (a cutoff above 1, a power
/// that is negative or not a number), and for a negative cutoff. Only d_i = max d and half of that
/// are tested.
template <Heuristic H>
void require_heuristic(const H& heuristic) {
  const double whole = heuristic.unnormalised(1.0), half = heuristic.unnormalised(0.5);
  require_argument(whole > 0.0 && whole <= std::numeric_limits<double>::max() && half >= 0.0 && half <= whole,
                   "the heuristic must be positive at 1, and below neither negative nor larger: a cutoff of 0 to 1, a "
                   "power that is not negative");
  if constexpr (std::same_as<H, Cutoff>) require_argument(heuristic.threshold >= 0.0, "a cutoff lies between 0 and 1");
}

namespace detail {
constexpr void require_same_sizes(std::size_t counts, std::size_t densities, std::size_t weights) {
  require_argument(counts == densities && weights == densities,
                   "the numbers of counts, densities and weights differ: give one of each for each technique");
}
}  // namespace detail

/// Writes the weights of all techniques at one point to `weights`, which may be the same memory as
/// `densities`.
///
/// `densities[i]` is p_i (not n_i p_i), `counts[i]` is n_i. The weights sum to one, or are all zero
/// when all d_i are zero. Infinite densities share all weight; a NaN or negative density makes all
/// weights NaN. Throws std::invalid_argument when the three sizes differ.
template <Heuristic H, std::floating_point T>
void heuristic_weights(const H& heuristic, std::span<const std::uint32_t> counts, std::span<const T> densities,
                       std::span<T> weights) {
  const std::size_t n = densities.size();
  detail::require_same_sizes(counts.size(), n, weights.size());
  T largest(0);
  bool any_infinite = false;
  bool all_valid = true;
  for (std::size_t i = 0; i < n; ++i) {
    if (!(densities[i] >= T(0))) all_valid = false;
    if (counts[i] == 0) continue;
    any_infinite = any_infinite || densities[i] > std::numeric_limits<T>::max();
    largest = std::max(largest, densities[i]);
  }
  if (!all_valid || largest == T(0)) {
    std::fill(weights.begin(), weights.end(), all_valid ? T(0) : std::numeric_limits<T>::quiet_NaN());
    return;
  }
  // First relative to the largest p, so that n_i p_i cannot overflow; then relative to the largest
  // d.
  T largest_ratio(0);
  for (std::size_t i = 0; i < n; ++i) {
    if (any_infinite)
      weights[i] = counts[i] > 0 && densities[i] > std::numeric_limits<T>::max() ? T(1) : T(0);
    else
      weights[i] = static_cast<T>(counts[i]) * (densities[i] / largest);
    largest_ratio = std::max(largest_ratio, weights[i]);
  }
  T sum(0), block(0);  // in blocks, so that a long sum is as exact as a short one
  for (std::size_t i = 0; i < n; ++i) {
    weights[i] = weights[i] > T(0) ? heuristic.unnormalised(weights[i] / largest_ratio) : T(0);
    block += weights[i];
    if (i % 64 == 63) sum += std::exchange(block, T(0));
  }
  sum += block;
  for (std::size_t i = 0; i < n; ++i) weights[i] /= sum;
}

/// The same from natural logarithms of the densities (−infinity for zero).
template <Heuristic H, std::floating_point T>
void heuristic_weights_from_logs(const H& heuristic, std::span<const std::uint32_t> counts,
                                 std::span<const T> log_densities, std::span<T> weights) {
  detail::require_same_sizes(counts.size(), log_densities.size(), weights.size());
  T largest = -std::numeric_limits<T>::infinity();
  for (std::size_t i = 0; i < log_densities.size(); ++i) {
    if (!(log_densities[i] == log_densities[i])) {
      std::fill(weights.begin(), weights.end(), std::numeric_limits<T>::quiet_NaN());
      return;
    }
    if (counts[i] > 0) largest = std::max(largest, log_densities[i]);
  }
  if (largest == -std::numeric_limits<T>::infinity()) return std::fill(weights.begin(), weights.end(), T(0));
  for (std::size_t i = 0; i < log_densities.size(); ++i) {
    // inf − inf: an infinite density relative to itself is one.
    const bool is_largest = log_densities[i] == largest;
    weights[i] = is_largest ? T(1) : counts[i] > 0 ? std::exp(log_densities[i] - largest) : T(0);
  }
  heuristic_weights(heuristic, counts, std::span<const T>(weights), weights);
}

}  // namespace gmis
