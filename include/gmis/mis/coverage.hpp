#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ranges>
#include <vector>

#include "gmis/mis/estimate.hpp"
#include "gmis/mis/groups.hpp"

namespace gmis {

/// What probing found. A probe counts when f ≠ 0 there.
template <class X>
struct Coverage {
  std::uint64_t probes = 0;              ///< points looked at
  std::uint64_t nonzero = 0;             ///< of these, with f ≠ 0
  std::uint64_t uncovered = 0;           ///< of these, with no proposal positive: every scheme misses them
  std::uint64_t partly_uncovered = 0;    ///< with some proposal positive and some zero: R1, R2, N1, N2 are biased. For
                                         ///< groups, with some group of all zeros: their partial mixture is biased
  std::uint64_t non_finite = 0;          ///< points where f or a density was not finite; not judged
  std::optional<X> uncovered_example{};  ///< the first uncovered point
  std::optional<X> partly_uncovered_example{};  ///< the first partly uncovered point

  /// True when no probe speaks against `scheme` being unbiased. Says nothing (true) when no probe met f ≠ 0.
  [[nodiscard]] constexpr bool allows(Scheme scheme) const noexcept {
    return uncovered == 0 && (!needs_full_support(scheme) || partly_uncovered == 0);
  }

  /// True when no probe speaks against the partial mixture of the groups that were checked being unbiased.
  [[nodiscard]] constexpr bool allows_groups() const noexcept { return uncovered == 0 && partly_uncovered == 0; }
};

/// Looks at `points` for places where f ≠ 0 and all proposals of a group are zero. Ask `allows_groups` of the result.
template <class Integrand, Proposals P, std::size_t GroupCapacity, std::ranges::input_range Points>
requires(!AnyProposal<Points>)
    [[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Groups<GroupCapacity>& groups,
                                      const Points& points) {
  const auto& set = as_proposal_set(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  Coverage<typename Set::Value> coverage;
  Workspace<typename Set::Density, dynamic_capacity> workspace;
  workspace.prepare(set.size(), 0);

  for (const typename Set::Value& x : points) {
    ++coverage.probes;
    const auto value = f(x);
    if (!is_finite(value)) {
      ++coverage.non_finite;
      continue;
    }
    if (is_zero_integrand(value)) continue;

    DensitiesAt<Set> densities(set, x, workspace.densities.data());
    densities.expect_all();
    std::size_t covering = 0;
    bool all_finite = true;
    for (std::size_t group = 0; group < groups.size(); ++group) {
      bool covers = false;
      for (const std::uint32_t k : groups.members(group)) {
        const DensityState state = state_of(DensitiesAt<Set>::as_denominator(densities[k]));
        if (state == DensityState::usable) covers = true;
        if (state == DensityState::non_finite) all_finite = false;
      }
      if (covers) ++covering;
    }
    if (!all_finite) {
      ++coverage.non_finite;
      continue;
    }
    ++coverage.nonzero;
    if (covering == 0) {
      if (coverage.uncovered++ == 0) coverage.uncovered_example = x;
    } else if (covering < groups.size()) {
      if (coverage.partly_uncovered++ == 0) coverage.partly_uncovered_example = x;
    }
  }
  return coverage;
}

/// Looks at `points` (any range of samples: a grid, draws of a broad proposal) for places where f ≠ 0 and proposals are
/// zero. No estimator can notice these by itself, since its samples only fall where some proposal is positive.
/// A test by sampling: it can find a hole, not prove that there is none.
template <class Integrand, Proposals P, std::ranges::input_range Points>
requires(!AnyProposal<Points>)
    [[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Points& points) {
  return check_coverage(f, proposals, Groups<>(as_proposal_set(proposals).size(), 1), points);
}

/// The same with `count` samples of `probe`, a proposal that covers everything where f might not be zero.
template <class Integrand, Proposals P, AnyProposal Probe, UniformSource Source>
[[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Probe& probe, std::uint64_t count,
                                  Source& source) {
  std::vector<ValueOf<Probe>> points;
  points.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto result = probe.sample(source);
    if constexpr (SampleResult<std::remove_cvref_t<decltype(result)>>::can_fail) {
      if (result) points.push_back(*result);
    } else {
      points.push_back(result);
    }
  }
  return check_coverage(f, proposals, points);
}

}  // namespace gmis
