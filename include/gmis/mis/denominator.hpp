#pragma once

#include <cstddef>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/mixture.hpp"
#include "gmis/mis/scheme.hpp"

namespace gmis {

/// The density of the proposal that made a sample, at that sample, and what the sample is divided
/// by.
template <class Set>
struct OwnAndDenominator {
  Denominator<Set> own;
  Denominator<Set> denominator;
};

/// φ_n at the point of `densities`, for sample n of the round, made by proposal `index`. Reads
/// `workspace` as `IndexSelector` left it.
template <Scheme scheme, Selection selection, class Set, class AllocationType, class WorkspaceType>
[[nodiscard]] GMIS_ALWAYS_INLINE inline OwnAndDenominator<Set> denominator_of(
    DensitiesAt<Set>& densities, const Set& set, const AllocationType& allocation, const WorkspaceType& workspace,
    std::size_t index, std::size_t n, std::size_t sample_count) {
  using T = typename Set::Density;
  MixtureSum<T, is_log_set<Set>> mixture;
  T own(0);
  // Adds proposal i, `times` over. Kept, so that the density of the proposal that made the sample
  // can be looked up after: that is cheaper than to ask of each whether it is the one.
  const auto add = [&](std::size_t i, auto... times) { mixture.add(densities.keep(i), times...); };

  constexpr bool is_single = AllocationType::is_equal && capacity_of<Set> == 1;
  if constexpr (scheme == Scheme::R1 || scheme == Scheme::N1 || is_single) {  // q_j
    own = densities[index];
    const Denominator<Set> denominator = DensitiesAt<Set>::as_denominator(own);
    return {denominator, denominator};
  } else if constexpr (scheme == Scheme::R3 || scheme == Scheme::N3) {  // ψ
    densities.expect_all();
    T normaliser(1);
    if constexpr (AllocationType::is_equal) {
      mixture = densities.mixture_of_all();
      own = densities.kept(index);
      normaliser = as_factor<T>(set.size());
    } else {
      for (std::size_t i = 0; i < set.size(); ++i) {
        const T coefficient =
            selection == Selection::S1 ? static_cast<T>(allocation.weight(i)) : static_cast<T>(allocation.count(i));
        if (coefficient > T(0)) {
          add(i, coefficient);
          densities.count(1);
        }
      }
      own = densities.kept(index);
      if constexpr (selection != Selection::S1) normaliser = as_factor<T>(sample_count);
    }
    return {DensitiesAt<Set>::as_denominator(own), mixture.over(normaliser)};
  } else if constexpr (scheme == Scheme::R2) {  // what this round drew, each distinct index evaluated once
    for (std::size_t i = 0; i < set.size(); ++i)
      if (workspace.multiplicity[i] > T(0)) {
        add(i, workspace.multiplicity[i]);
        densities.count(1);
      }
    own = densities.kept(index);
    return {DensitiesAt<Set>::as_denominator(own), mixture.over(as_factor<T>(sample_count))};
  } else {  // N2: what could still be drawn, this sample included; summed afresh, since a difference would cancel
    if constexpr (AllocationType::is_equal) {
      for (std::size_t m = sample_count; --m > n;) mixture.add(densities.uncounted(workspace.order[m]));
      own = densities.uncounted(index);  // which is order[n]
      mixture.add(own);
      densities.count(sample_count - n);
    } else {
      for (std::size_t i = 0; i < set.size(); ++i)
        if (workspace.multiplicity[i] > T(0)) {
          add(i, workspace.multiplicity[i]);
          densities.count(1);
        }
      own = densities.kept(index);
    }
    return {DensitiesAt<Set>::as_denominator(own), mixture.over(as_factor<T>(sample_count - n))};
  }
}

}  // namespace gmis
