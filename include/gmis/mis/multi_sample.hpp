#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <type_traits>

#include "gmis/core/ieee.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/heuristic.hpp"

namespace gmis {

/// Draws one round of the multi-sample form: proposal i makes n_i = `allocation.count(i)` samples,
/// and a sample of i is weighted by `heuristic`. Calls `visit(x, denominator, index)` where the
/// denominator is n_i q_i(x) / (n w_i(x)), so that as for every other round (1/n) Σ f / denominator
/// estimates ∫ f, n = Σ n_i. Samples of weight zero, or of one whose inverse is out of range,
/// contribute zero and are not visited. The denominator of Balance is that of N3.
///
/// Unbiased when every point with f ≠ 0 has a proposal with n_i q_i > 0. Throws
/// std::invalid_argument when the allocation does not fit the set. The heuristic is not checked:
/// `require_heuristic` does so, once for all rounds.
template <Heuristic H, class Set, class AllocationType, UniformSource Source, std::size_t Capacity, class Visit>
requires ProposalSet<Set, Source> RoundCounts
sample_weighted_round(const H& heuristic, const Set& set, const AllocationType& allocation, Source& source,
                      Workspace<typename Set::Density, Capacity>& workspace, Visit&& visit) {
  using D = typename Set::Density;
  const std::size_t proposal_count = set.size();
  const std::size_t sample_count = allocation.sample_count(proposal_count);
  allocation.require_fits(proposal_count, Selection::S3);
  workspace.prepare(proposal_count, proposal_count);
  // Samples come in the order of their proposals, so that `order` is free to hold the counts.
  for (std::size_t i = 0; i < proposal_count; ++i) workspace.order[i] = allocation.count(i);
  const std::span<const std::uint32_t> sample_counts(workspace.order.data(), proposal_count);
  const std::span<D> densities(workspace.densities.data(), proposal_count);

  RoundCounts counts;
  for (std::size_t n = 0; n < sample_count; ++n) {
    const std::size_t index = allocation.proposal_of_slot(n);
    const auto result = set.sample(index, source);
    const typename Set::Value* x = nullptr;
    if constexpr (SampleResult<std::remove_cvref_t<decltype(result)>>::can_fail) {
      if (!result) {
        ++counts.failed_samples;
        continue;
      }
      x = &*result;
    } else {
      x = &result;
    }

    DensitiesAt<Set> at(set, *x, densities.data());
    at.expect_all();
    bool are_finite = true;
    for (std::size_t i = 0; i < proposal_count; ++i) {
      densities[i] = sample_counts[i] > 0 ? at[i] : (is_log_set<Set> ? -std::numeric_limits<D>::infinity() : D(0));
      // One of another proposal that is not finite would make the weight 0 and the sample vanish.
      are_finite = are_finite && state_of(DensitiesAt<Set>::as_denominator(densities[i])) != DensityState::non_finite;
    }
    counts.density_evaluations += at.evaluations();
    const Denominator<Set> own = DensitiesAt<Set>::as_denominator(densities[index]);
    if (state_of(own) == DensityState::zero) {
      ++counts.zero_density;
      continue;
    }
    const std::span<const D> values(densities);
    if constexpr (is_log_set<Set>)
      heuristic_weights_from_logs(heuristic, sample_counts, values, densities);
    else
      heuristic_weights(heuristic, sample_counts, values, densities);
    const D weight = densities[index];
    if (!are_finite || !(weight >= D(0))) {
      ++counts.non_finite_density;
      continue;
    }
    // Infinite for the weight 0, and for one so small that what the sample adds is lost in
    // rounding.
    const D factor = ieee_divide(static_cast<D>(sample_counts[index]) / static_cast<D>(sample_count), weight);
    if (!std::isfinite(factor)) continue;
    Denominator<Set> denominator = own;
    if constexpr (is_log_set<Set>)
      denominator.log += std::log(factor);
    else
      denominator *= factor;
    if (state_of(denominator) == DensityState::non_finite) {
      ++counts.non_finite_density;
      continue;
    }
    visit(*x, denominator, index);
  }
  return counts;
}

/// Estimates ∫ f with `rounds` ≥ 1 rounds of the multi-sample form under `heuristic` (Balance,
/// Power, Cutoff, Maximum, or one of your own). As `estimate`, otherwise; also throws
/// std::invalid_argument as `require_heuristic` does.
template <Heuristic H, class Integrand, class P, class Source, class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate_weighted(const H& heuristic, Integrand&& f, const P& proposals,
                                                                 std::uint64_t rounds, Source&& source,
                                                                 const AllocationType& allocation = {}) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none) {
    const auto& set = as_proposal_set<std::remove_reference_t<Source>>(proposals);
    using Set = std::remove_cvref_t<decltype(set)>;
    require_rounds(rounds);
    require_heuristic(heuristic);
    allocation.require_fits(set.size(), Selection::S3);
    Workspace<typename Set::Density, dynamic_capacity> workspace;
    EstimateAccumulator<SummandOf<Integrand, typename Set::Value>> accumulator;
    for (std::uint64_t round = 0; round < rounds; ++round)
      accumulator.add_round(f, allocation.sample_count(set.size()), [&](auto&& visit) {
        return sample_weighted_round(heuristic, set, allocation, source, workspace, visit);
      });
    return accumulator.result();
  } else {
    return {};
  }
}

}  // namespace gmis
