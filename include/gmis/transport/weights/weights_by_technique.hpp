#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <limits>

#include "gmis/core/extended.hpp"
#include "gmis/transport/state/technique.hpp"
#include "gmis/transport/weights/weight_formulas.hpp"

/// \file
/// Weights of one path under many sample allocations. The sum of all densities of a path is linear
/// in the counts of the techniques. The recursion therefore runs on vectors with one sum per
/// technique (connections at all vertices together, merges at all vertices together); the weight
/// under any other counts follows from these sums. An alternative is to correct the weights
/// afterwards [Grittmann et al. 2022].

namespace gmis {

/// One value per `Technique`.
template <class X>
using PerTechnique = std::array<X, technique_count>;

/// The expected sample density of a path by each technique, divided by the density of the technique
/// that made it.
template <std::floating_point T>
struct TechniqueDensities {
  Technique own;             ///< made the path
  PerTechnique<T> relative;  ///< without unit; all 0 when the density of `own` is 0

  /// The balance weight 1 / Σ relative with the counts of the rendering; 0 when the density of
  /// `own` is 0.
  [[nodiscard]] constexpr T weight() const noexcept {
    T sum(0);
    for (const T density : relative) sum += density;
    return sum > T(0) ? T(1) / sum : T(0);
  }
};

/// A sum over techniques with a separate term for each.
template <class Number>
struct SumByTechnique {
  Technique own{};
  PerTechnique<Number> terms{};

  [[nodiscard]] friend constexpr SumByTechnique operator+(SumByTechnique a, const SumByTechnique& b) noexcept {
    for (std::size_t i = 0; i < technique_count; ++i) a.terms[i] = a.terms[i] + b.terms[i];
    return a;
  }
  [[nodiscard]] friend constexpr SumByTechnique operator*(SumByTechnique a, Number factor) noexcept {
    for (Number& term : a.terms) term = term * factor;
    return a;
  }
  [[nodiscard]] friend constexpr SumByTechnique operator*(Number factor, const SumByTechnique& a) noexcept {
    return a * factor;
  }
};

/// A `Sums` policy of `WeightRecursion` whose weights are `TechniqueDensities`. Its members are
/// those of `WholeSum`, term by term.
template <std::floating_point T>
struct SeparateSums {
  using Sum = SumByTechnique<Extended<T>>;
  using PlainSum = SumByTechnique<double>;
  using Weight = TechniqueDensities<T>;

  template <Technique technique, class Number>
  [[nodiscard]] static constexpr SumByTechnique<Number> of(Number density) noexcept {
    SumByTechnique<Number> sum;
    sum.own = technique;
    sum.terms[static_cast<std::size_t>(technique)] = density;
    return sum;
  }
  [[nodiscard]] static constexpr Weight weight(const OwnAndOthers<Sum>& of) noexcept {
    const auto& [own, others] = of;
    const Extended<T> unit = own.terms[static_cast<std::size_t>(own.own)];
    Weight weight{own.own, {}};
    if (unit.is_zero()) return weight;
    const Sum sum = own + others;
    for (std::size_t i = 0; i < technique_count; ++i) weight.relative[i] = (sum.terms[i] / unit).value();
    return weight;
  }
  [[nodiscard]] static constexpr Weight weight(const OwnAndOthers<PlainSum>& of) noexcept {
    const auto& [own, others] = of;
    const double unit = own.terms[static_cast<std::size_t>(own.own)];
    Weight weight{own.own, {}};
    if (unit == 0.0) return weight;
    constexpr double most = std::numeric_limits<T>::max();
    for (std::size_t i = 0; i < technique_count; ++i) {
      const double relative = (own.terms[i] + others.terms[i]) / unit;
      weight.relative[i] = relative <= most ? static_cast<T>(relative) : std::numeric_limits<T>::infinity();
    }
    return weight;
  }
  [[nodiscard]] static constexpr bool is_plain(const Sum& sum) noexcept {
    bool all = true;
    for (const Extended<T>& term : sum.terms) all = all && term.has_no_exponent();
    return all;
  }
  [[nodiscard]] static constexpr PlainSum plain(const Sum& sum) noexcept {
    PlainSum plain{sum.own, {}};
    for (std::size_t i = 0; i < technique_count; ++i) plain.terms[i] = static_cast<double>(sum.terms[i].mantissa());
    return plain;
  }
  [[nodiscard]] static constexpr Sum stored(const PlainSum& sum) noexcept {
    Sum stored{sum.own, {}};
    for (std::size_t i = 0; i < technique_count; ++i) stored.terms[i] = Extended<T>::rounded(sum.terms[i]);
    return stored;
  }
};

}  // namespace gmis
