#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

#include "gmis/mis/estimate.hpp"
#include "gmis/mis/groups.hpp"

namespace gmis {

/// The result of probing. A probe counts when f ≠ 0 there.
template <class X>
struct Coverage {
  std::uint64_t probes = 0;              ///< points looked at
  std::uint64_t nonzero = 0;             ///< of these, with f ≠ 0
  std::uint64_t uncovered = 0;           ///< of these, with no proposal positive: every scheme misses them
  std::uint64_t partly_uncovered = 0;    ///< with some proposal positive and some zero: R1, R2, N1, N2 are biased. For
                                         ///< groups, with some group of all zeros: their partial mixture is biased. For
                                         ///< an allocation, proposals without samples do not count
  std::uint64_t non_finite = 0;          ///< points where f or a density was not finite, or a density negative
  std::uint64_t bad_density = 0;         ///< of these, where a density was: estimates reject what falls there
  std::optional<X> uncovered_example{};  ///< the first uncovered point
  std::optional<X> partly_uncovered_example{};  ///< the first partly uncovered point

  /// True when no probe speaks against `scheme` being unbiased. Says nothing (true) when no probe
  /// met f ≠ 0.
  [[nodiscard]] constexpr bool allows(Scheme scheme) const noexcept {
    return uncovered == 0 && bad_density == 0 && (!needs_full_support(scheme) || partly_uncovered == 0);
  }

  /// True when no probe speaks against the partial mixture of the groups that were checked being
  /// unbiased.
  [[nodiscard]] constexpr bool allows_groups() const noexcept {
    return uncovered == 0 && bad_density == 0 && partly_uncovered == 0;
  }
};

namespace detail {

/// Looks at `points`; `judge(is_positive)` returns how many parts of the set cover a point, and of
/// how many.
template <class Source, class Integrand, class P, class Points, class Judge>
[[nodiscard]] auto check_coverage(Integrand& f, const P& proposals, const Points& points, Judge&& judge) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  Coverage<typename Set::Value> coverage;
  Workspace<typename Set::Density, dynamic_capacity> workspace;
  workspace.prepare(set.size(), 0);

  for (const typename Set::Value& x : points) {
    ++coverage.probes;
    const auto value = value_of(f, x);
    if (!is_finite(value)) {
      ++coverage.non_finite;
      continue;
    }
    if (is_black(value)) continue;

    DensitiesAt<Set> densities(set, x, workspace.densities.data());
    densities.expect_all();
    bool all_finite = true;
    const auto [covering, parts] = judge([&](std::size_t i) {
      const DensityState state = state_of(DensitiesAt<Set>::as_denominator(densities[i]));
      if (state == DensityState::non_finite) all_finite = false;
      return state == DensityState::usable;
    });
    if (!all_finite) {
      ++coverage.non_finite;
      ++coverage.bad_density;
      continue;
    }
    ++coverage.nonzero;
    if (covering == 0) {
      if (coverage.uncovered++ == 0) coverage.uncovered_example = x;
    } else if (covering < parts) {
      if (coverage.partly_uncovered++ == 0) coverage.partly_uncovered_example = x;
    }
  }
  return coverage;
}

struct CoveringParts {
  std::size_t covering = 0, parts = 0;
};

}  // namespace detail

/// Looks at `points` for places where f ≠ 0 and all proposals of a group are zero. Ask
/// `allows_groups` of the result. Throws std::invalid_argument when the groups are those of another
/// number of proposals.
template <class Source = Philox, class Integrand, class P, std::size_t GroupCapacity, class Points>
requires(!AnyProposal<Points, Source>)
    [[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Groups<GroupCapacity>& groups,
                                      const Points& points) {
  if constexpr (detail::explain_arguments<Integrand, P, Source>()) {
    groups.require_fits(as_proposal_set<Source>(proposals).size());
    return detail::check_coverage<Source>(f, proposals, points, [&](auto is_positive) {
      detail::CoveringParts result{0, groups.size()};
      for (std::size_t group = 0; group < groups.size(); ++group) {
        bool covers = false;
        for (const std::uint32_t i : groups.members(group)) covers |= is_positive(i);
        if (covers) ++result.covering;
      }
      return result;
    });
  } else {
    return Coverage<double>{};
  }
}

/// Looks at `points` for places where f ≠ 0 and the proposals that `allocation` gives samples are
/// zero: those that it leaves out cover nothing. Throws std::invalid_argument when the allocation
/// is for another number of proposals, or leaves one of positive weight without a sample.
template <class Source = Philox, class Integrand, class P, std::floating_point T, std::size_t Capacity, class Points>
requires(!AnyProposal<Points, Source>)
    [[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals,
                                      const SampleAllocation<T, Capacity>& allocation, const Points& points) {
  if constexpr (detail::explain_arguments<Integrand, P, Source>()) {
    const std::size_t size = as_proposal_set<Source>(proposals).size();
    allocation.require_fits(size, Selection::S3);
    return detail::check_coverage<Source>(f, proposals, points, [&](auto is_positive) {
      detail::CoveringParts result;
      for (std::size_t i = 0; i < size; ++i) {
        if (allocation.count(i) == 0) continue;
        ++result.parts;
        if (is_positive(i)) ++result.covering;
      }
      return result;
    });
  } else {
    return Coverage<double>{};
  }
}

/// Looks at `points` (any range of samples: a grid, draws of a broad proposal) for places where f ≠
/// 0 and proposals are zero. No estimator can notice these by itself, since its samples only fall
/// where some proposal is positive. A test by sampling: it can find a hole, not prove that there is
/// none.
template <class Source = Philox, class Integrand, class P, class Points>
requires(!AnyProposal<Points, Source>)
    [[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Points& points) {
  if constexpr (detail::explain_arguments<Integrand, P, Source>()) {
    const std::size_t size = as_proposal_set<Source>(proposals).size();
    EqualAllocation{}.require_fits(size, Selection::S3);
    return check_coverage<Source>(f, proposals, Groups<>(size, 1), points);
  } else {
    return Coverage<double>{};
  }
}

/// `count` ≥ 1 samples of `probe`, less those that it failed to make: points for `check_coverage`.
template <class Probe, UniformSource Source>
requires AnyProposal<Probe, Source>
[[nodiscard]] std::vector<ValueOf<Probe, Source>> probe_points(const Probe& probe, std::uint64_t count,
                                                               Source& source) {
  require_argument(count > 0, "no probes: ask for at least one");
  std::vector<ValueOf<Probe, Source>> points;
  points.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto result = probe.sample(source);
    if constexpr (SampleResult<std::remove_cvref_t<decltype(result)>>::can_fail) {
      if (result) points.push_back(*result);
    } else {
      points.push_back(result);
    }
  }
  return points;
}

/// `check_coverage` at `count` samples of `probe`, a proposal that covers every point where f might
/// not be zero.
template <class Integrand, class P, class Probe, UniformSource Source>
requires AnyProposal<Probe, Source>
[[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Probe& probe, std::uint64_t count,
                                  Source& source) {
  return check_coverage<Source>(f, proposals, probe_points(probe, count, source));
}

/// `check_coverage` at `count` samples of `probe`, for an allocation or for groups.
template <class Integrand, class P, class Division, class Probe, UniformSource Source>
requires AnyProposal<Probe, Source>
[[nodiscard]] auto check_coverage(Integrand&& f, const P& proposals, const Division& division, const Probe& probe,
                                  std::uint64_t count, Source& source) {
  return check_coverage<Source>(f, proposals, division, probe_points(probe, count, source));
}

}  // namespace gmis
