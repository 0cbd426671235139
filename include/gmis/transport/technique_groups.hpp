#pragma once

#include <array>
#include <cstddef>

#include "gmis/core/extended.hpp"
#include "gmis/transport/technique.hpp"

/// \file
/// Weights for many choices of counts at once. What a path's techniques add up to is linear in their counts, so with one
/// sum for each group of techniques whose counts change together, the weights under any counts follow from the one path:
/// the recursion runs on vectors [Grittmann et al. 2022 correct the weights instead].

namespace gmis {

/// Emitter hits and next events; connections with light vertices; splats; merging.
enum class TechniqueGroup : std::uint8_t { camera, connect, splat, merge };
inline constexpr std::size_t technique_groups = 4;

[[nodiscard]] constexpr TechniqueGroup group_of(Technique technique) noexcept {
  switch (technique) {
    case Technique::emitter_hit:
    case Technique::next_event:
      break;
    case Technique::connect:
      return TechniqueGroup::connect;
    case Technique::splat:
      return TechniqueGroup::splat;
    case Technique::merge:
      return TechniqueGroup::merge;
  }
  return TechniqueGroup::camera;
}

/// A number for each group.
template <class X>
using PerGroup = std::array<X, technique_groups>;

/// Expected densities of a path by the techniques of each group, over that of the technique that made it.
template <std::floating_point T>
struct GroupDensities {
  TechniqueGroup own;
  PerGroup<T> relative;

  /// Σ over the groups, their counts multiplied by `factors`.
  [[nodiscard]] constexpr T total(const PerGroup<T>& factors) const noexcept {
    T sum(0);
    for (std::size_t g = 0; g < technique_groups; ++g)
      if (factors[g] > T(0)) sum += factors[g] * relative[g];  // 0 times infinity is not meant
    return sum;
  }
  /// The balance weight with the counts as they were.
  [[nodiscard]] constexpr T weight() const noexcept {
    const T sum = total({T(1), T(1), T(1), T(1)});
    return sum > T(0) ? T(1) / sum : T(0);
  }
};

/// A sum over techniques, the groups kept apart.
template <std::floating_point T>
struct GroupedSum {
  TechniqueGroup own{};
  PerGroup<Extended<T>> terms{};

  [[nodiscard]] friend constexpr GroupedSum operator+(GroupedSum a, const GroupedSum& b) noexcept {
    for (std::size_t g = 0; g < technique_groups; ++g) a.terms[g] = a.terms[g] + b.terms[g];
    return a;
  }
  [[nodiscard]] friend constexpr GroupedSum operator*(GroupedSum a, Extended<T> factor) noexcept {
    for (Extended<T>& term : a.terms) term = term * factor;
    return a;
  }
  [[nodiscard]] friend constexpr GroupedSum operator*(Extended<T> factor, const GroupedSum& a) noexcept {
    return a * factor;
  }
};

/// What `WeightRecursion` sums so that its weights are `GroupDensities`.
template <std::floating_point T>
struct GroupSums {
  using Sum = GroupedSum<T>;
  using Weight = GroupDensities<T>;

  template <Technique technique>
  [[nodiscard]] static constexpr Sum of(Extended<T> density) noexcept {
    Sum sum;
    sum.own = group_of(technique);
    sum.terms[static_cast<std::size_t>(sum.own)] = density;
    return sum;
  }
  [[nodiscard]] static constexpr Weight weight(const Sum& own, const Sum& others) noexcept {
    const Extended<T> unit = own.terms[static_cast<std::size_t>(own.own)];
    Weight weight{own.own, {}};
    if (unit.is_zero()) return weight;
    const Sum sum = own + others;
    for (std::size_t g = 0; g < technique_groups; ++g) weight.relative[g] = (sum.terms[g] / unit).value();
    return weight;
  }
};

}  // namespace gmis
