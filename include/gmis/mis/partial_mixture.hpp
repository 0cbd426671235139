#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/groups.hpp"

namespace gmis {

/// One round of the partial deterministic mixture [Elvira, Martino, Luengo, Bugallo: Efficient
/// multiple importance sampling estimators, 2015, eq. 9]: every proposal makes one sample, which is
/// divided by the mixture of its own group, (1/P) Σ q_i over the P proposals of the group. A dial
/// from N1 (groups of one, N evaluations of densities a round) to N3 (a single group, N²): groups
/// of P cost N P. Calls `visit(x, denominator, index)`; (1/N) Σ f / denominator estimates ∫ f.
///
/// Unbiased for every partition in which the mixture of *each* group is positive wherever f ≠ 0;
/// `check_coverage(f, proposals, groups, …)` looks for places where it is not.
/// Throws std::invalid_argument when the groups are for another number of proposals.
template <class Set, std::size_t GroupCapacity, UniformSource Source, std::size_t Capacity, class Visit>
requires ProposalSet<Set, Source> GMIS_ALWAYS_INLINE inline RoundCounts sample_partial_round(
    const Set& set, const Groups<GroupCapacity>& groups, Source& source,
    Workspace<typename Set::Density, Capacity>& workspace, Visit&& visit) {
  groups.require_fits(set.size());
  using T = typename Set::Density;
  workspace.prepare(set.size(), 0);
  RoundCounts counts;
  for (std::size_t group = 0; group < groups.size(); ++group) {
    const std::span<const std::uint32_t> members = groups.members(group);
    for (const std::uint32_t index : members)
      visit_sample<false>(
          set, index, source, workspace, counts,
          [&](DensitiesAt<Set>& densities) {
            MixtureSum<T, is_log_set<Set>> mixture;
            if (members.size() == set.size()) {
              densities.expect_all();
              mixture = densities.mixture_of_all();
            } else {
              for (const std::uint32_t i : members) mixture.add(densities.keep(i));
              densities.count(members.size());
            }
            return OwnAndDenominator<Set>{DensitiesAt<Set>::as_denominator(densities.kept(index)),
                                          mixture.over(as_factor<T>(members.size()))};
          },
          [] {}, visit);
  }
  return counts;
}

/// Estimates ∫ f with `rounds` ≥ 1 rounds of the partial deterministic mixture. As `estimate`,
/// otherwise.
template <class Integrand, class P, std::size_t GroupCapacity, class Source>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate_partial(Integrand&& f, const P& proposals,
                                                                const Groups<GroupCapacity>& groups,
                                                                std::uint64_t rounds, Source&& source) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none) {
    const auto& set = as_proposal_set<std::remove_reference_t<Source>>(proposals);
    using Set = std::remove_cvref_t<decltype(set)>;
    require_rounds(rounds);
    Workspace<typename Set::Density, capacity_of<Set>> workspace;
    EstimateAccumulator<SummandOf<Integrand, typename Set::Value>> accumulator;
    for (std::uint64_t round = 0; round < rounds; ++round)
      accumulator.add_round(f, set.size(),
                            [&](auto&& visit) { return sample_partial_round(set, groups, source, workspace, visit); });
    return accumulator.result();
  } else {
    return {};
  }
}

}  // namespace gmis
