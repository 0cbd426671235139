#pragma once

#include <array>
#include <cstddef>

#include "gmis/core/extended.hpp"
#include "gmis/transport/techniques/technique.hpp"

/// \file
/// Weights for many choices of counts at once. What a path's techniques add up to is linear in their counts, so with one
/// sum for each technique (connections and merging at all their vertices together), the weights under any counts follow
/// from the one path: the recursion runs on vectors [Grittmann et al. 2022 correct the weights instead].

namespace gmis {

/// A number for each `Technique`.
template <class X>
using PerTechnique = std::array<X, technique_count>;

/// Expected densities of a path by each technique, over that of the one that made it.
template <std::floating_point T>
struct TechniqueDensities {
  Technique own;
  PerTechnique<T> relative;

  /// Σ over the techniques, their counts multiplied by `factors`.
  [[nodiscard]] constexpr T total(const PerTechnique<T>& factors) const noexcept {
    T sum(0);
    for (std::size_t i = 0; i < technique_count; ++i)
      if (factors[i] > T(0)) sum += factors[i] * relative[i];  // 0 times infinity is not meant
    return sum;
  }
  /// The balance weight with the counts as they were.
  [[nodiscard]] constexpr T weight() const noexcept {
    T sum(0);
    for (const T density : relative) sum += density;
    return sum > T(0) ? T(1) / sum : T(0);
  }
};

/// A sum over techniques, each kept apart.
template <std::floating_point T>
struct SumByTechnique {
  Technique own{};
  PerTechnique<Extended<T>> terms{};

  [[nodiscard]] friend constexpr SumByTechnique operator+(SumByTechnique a, const SumByTechnique& b) noexcept {
    for (std::size_t i = 0; i < technique_count; ++i) a.terms[i] = a.terms[i] + b.terms[i];
    return a;
  }
  [[nodiscard]] friend constexpr SumByTechnique operator*(SumByTechnique a, Extended<T> factor) noexcept {
    for (Extended<T>& term : a.terms) term = term * factor;
    return a;
  }
  [[nodiscard]] friend constexpr SumByTechnique operator*(Extended<T> factor, const SumByTechnique& a) noexcept {
    return a * factor;
  }
};

/// What `WeightRecursion` sums so that its weights are `TechniqueDensities`.
template <std::floating_point T>
struct SeparateSums {
  using Sum = SumByTechnique<T>;
  using Weight = TechniqueDensities<T>;

  template <Technique technique>
  [[nodiscard]] static constexpr Sum of(Extended<T> density) noexcept {
    Sum sum;
    sum.own = technique;
    sum.terms[static_cast<std::size_t>(technique)] = density;
    return sum;
  }
  [[nodiscard]] static constexpr Weight weight(const Sum& own, const Sum& others) noexcept {
    const Extended<T> unit = own.terms[static_cast<std::size_t>(own.own)];
    Weight weight{own.own, {}};
    if (unit.is_zero()) return weight;
    const Sum sum = own + others;
    for (std::size_t i = 0; i < technique_count; ++i) weight.relative[i] = (sum.terms[i] / unit).value();
    return weight;
  }
};

}  // namespace gmis
