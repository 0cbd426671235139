#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/denominator.hpp"
#include "gmis/mis/mixture.hpp"
#include "gmis/mis/proposal_set.hpp"
#include "gmis/mis/sample_allocation.hpp"
#include "gmis/mis/scheme.hpp"
#include "gmis/mis/selection.hpp"
#include "gmis/mis/workspace.hpp"

namespace gmis {

/// Events of one round. Samples that were not made, or whose density is zero or not finite,
/// are not visited: they contribute zero.
struct RoundCounts {
  std::size_t density_evaluations = 0;  ///< of proposals
  std::size_t failed_samples = 0;       ///< `sample` returned nothing; no error
  std::size_t zero_density = 0;         ///< a proposal's density at its own sample was zero; an error of the proposal
  std::size_t non_finite_density = 0;   ///< a density was infinite, NaN or negative; an error of the proposal
};

/// Counts why a sample cannot be used. Out of line, so that no register is kept for what almost
/// never happens.
template <class D>
GMIS_RARE void count_unusable(D own, D denominator, RoundCounts& counts) noexcept {
  const DensityState own_state = state_of(own);
  const DensityState state = own_state == DensityState::usable ? state_of(denominator) : own_state;
  ++(state == DensityState::zero ? counts.zero_density : counts.non_finite_density);
}

/// Draws one sample of proposal `index` and hands it to `visit(x, denominator, index)` if it can be
/// used, else counts why not. `weigh(densities)` returns its own density and the denominator;
/// `discard()` is called when both are known, or when no sample was made.
template <bool divided_by_own, class Set, class Source, class WorkspaceType, class Weigh, class Discard, class Visit>
GMIS_ALWAYS_INLINE inline void visit_sample(const Set& set, std::size_t index, Source& source, WorkspaceType& workspace,
                                            RoundCounts& counts, Weigh&& weigh, Discard&& discard, Visit& visit) {
  const auto result = set.sample(index, source);
  using Result = SampleResult<std::remove_cvref_t<decltype(result)>>;
  const typename Set::Value* x = nullptr;
  if constexpr (Result::can_fail) {
    if (!result) {
      ++counts.failed_samples;
      discard();
      return;
    }
    x = &*result;
  } else {
    x = &result;
  }

  DensitiesAt<Set> densities(set, *x, workspace.densities.data());
  const auto [own, denominator] = weigh(densities);
  discard();
  counts.density_evaluations += densities.evaluations();
  if (divided_by_own ? is_usable(denominator) : is_usable(own, denominator)) [[likely]] {
    visit(*x, denominator, index);
  } else {
    count_unusable(own, denominator, counts);
  }
}

/// `sample_round` without the checks of its arguments, which a caller of many rounds makes once:
/// the allocation fits the set, and `workspace.prepare(set.size(), n)` was called. Adds what
/// happened to `counts`.
template <Selection selection, Weighting weighting, class Set, class AllocationType, class Source, std::size_t Capacity,
          class Visit>
GMIS_ALWAYS_INLINE inline void sample_checked_round(const Set& set, const AllocationType& allocation, Source& source,
                                                    Workspace<typename Set::Density, Capacity>& workspace,
                                                    RoundCounts& counts, Visit&& visit) {
  constexpr Scheme scheme = scheme_of(selection, weighting);
  const std::size_t proposal_count = set.size();
  const std::size_t sample_count = allocation.sample_count(proposal_count);

  IndexSelector<selection, scheme, AllocationType, Source, Workspace<typename Set::Density, Capacity>> selector(
      allocation, source, workspace, proposal_count, sample_count);
  for (std::size_t n = 0; n < sample_count; ++n) {
    const std::size_t index = selector.next(n);
    visit_sample<scheme == Scheme::R1 || scheme == Scheme::N1>(
        set, index, source, workspace, counts,
        [&](DensitiesAt<Set>& densities) GMIS_ALWAYS_INLINE_LAMBDA {
          return denominator_of<scheme, selection>(densities, set, allocation, workspace, index, n, sample_count);
        },
        [&] { selector.discard(n); }, visit);
  }
}

/// Draws one round of samples and calls `visit(x, denominator, index)` for each: the sample, the
/// density φ(x) that the pair of selection and weighting divides it by, and the index of the
/// proposal that made it. With n = `allocation.sample_count(N)` samples in the round, (1/n) Σ f(x)
/// / φ(x) estimates ∫ f.
///
/// `denominator` is a `Set::Density`, or a `LogDensity` of it for a set with logarithms. No
/// allocation beyond `workspace.prepare`, and none at all for a workspace with fixed capacity.
/// Throws std::invalid_argument when the allocation does not fit the set, or a fixed workspace is
/// too small.
template <Selection selection, Weighting weighting, class Set, class AllocationType, UniformSource Source,
          std::size_t Capacity, class Visit>
requires ProposalSet<Set, Source> GMIS_ALWAYS_INLINE inline RoundCounts sample_round(
    const Set& set, const AllocationType& allocation, Source& source,
    Workspace<typename Set::Density, Capacity>& workspace, Visit&& visit) {
  allocation.require_fits(set.size(), selection);
  workspace.prepare(set.size(), allocation.sample_count(set.size()));
  RoundCounts counts;
  sample_checked_round<selection, weighting>(set, allocation, source, workspace, counts, visit);
  return counts;
}

/// `sample_round` for a scheme, run as its cheapest pair.
template <Scheme scheme, class Set, class AllocationType, UniformSource Source, std::size_t Capacity, class Visit>
requires ProposalSet<Set, Source> GMIS_ALWAYS_INLINE inline RoundCounts sample_round(
    const Set& set, const AllocationType& allocation, Source& source,
    Workspace<typename Set::Density, Capacity>& workspace, Visit&& visit) {
  constexpr SelectionAndWeighting pair = cheapest_pair(scheme);
  return sample_round<pair.selection, pair.weighting>(set, allocation, source, workspace, std::forward<Visit>(visit));
}

/// `sample_round` for anything accepted as a set of proposals, one sample of each; the workspace is
/// on the stack when a bound on the number of proposals is known at compile time.
template <Scheme scheme, class P, UniformSource Source, class Visit>
requires Proposals<P, Source> RoundCounts sample_round(const P& proposals, Source& source, Visit&& visit) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  static_assert(capacity_of<Set> != dynamic_capacity,
                "the number of proposals is not bounded at compile time: pass an allocation and a Workspace");
  Workspace<typename Set::Density, capacity_of<Set>> workspace;
  return sample_round<scheme>(set, EqualAllocation{}, source, workspace, std::forward<Visit>(visit));
}

}  // namespace gmis
