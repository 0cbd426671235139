#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/round.hpp"

namespace gmis {

/// Sample counts: proposal k makes counts[k] samples a round.
using CountsByProposal = std::span<const std::uint32_t>;

/// Σ n_k. Throws std::invalid_argument when there is not one count for each proposal, or when all
/// are zero.
[[nodiscard]] inline std::size_t checked_total(CountsByProposal counts, std::size_t proposal_count) {
  if (counts.size() != proposal_count) reject_argument("give one sample count for each proposal");
  std::size_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  if (total == 0) reject_argument("give at least one proposal a sample count above zero");
  return total;
}

/// Working memory of a counted round: keep one per thread.
template <class Set>
using CountedWorkspace = Workspace<typename Set::Density, dynamic_capacity>;

/// Draws one round of N3 with counts, and hands over the densities that it computed: calls
/// `visit(x, psi, relative, index)` with ψ(x) = Σ n_k q_k(x) / n, n = Σ n_k, and relative[k] =
/// q_k(x)/ψ(x) for *all* proposals, those without samples included. Relative densities stay in
/// range where densities do not, and Σ n_k relative[k] = n. (1/n) Σ f(x)/psi estimates ∫ f;
/// unbiased when ψ > 0 wherever f ≠ 0. A sample counts as non_finite_density and is not visited
/// where any density is infinite, NaN or negative, that of a proposal without samples included.
///
/// `relative` is a span of `Set::Density`, to be read before `visit` returns. `counts` must have
/// passed `checked_total`. `before_sample(k, i)` is called before sample i of proposal k is drawn:
/// the place to set a source to its point.
template <class Set, UniformSource Source, class Visit, class BeforeSample>
requires ProposalSet<Set, Source> RoundCounts sample_counted_round(const Set& set, CountsByProposal counts,
                                                                   Source& source, CountedWorkspace<Set>& workspace,
                                                                   Visit&& visit, BeforeSample&& before_sample) {
  using T = typename Set::Density;
  const std::size_t proposal_count = set.size();
  workspace.prepare(proposal_count, 0);
  std::size_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  T* const kept = workspace.densities.data();

  const auto hand_over = [&](const typename Set::Value& x, Denominator<Set> psi, std::size_t index) {
    for (std::size_t k = 0; k < proposal_count; ++k) {
      if constexpr (is_log_set<Set>)
        kept[k] = std::exp(kept[k] - psi.log);
      else
        kept[k] /= psi;
    }
    visit(x, psi, std::span<const T>(kept, proposal_count), index);
  };
  RoundCounts result;
  for (std::size_t index = 0; index < proposal_count; ++index)
    for (std::uint32_t i = 0; i < counts[index]; ++i) {
      before_sample(index, i);
      visit_sample<false>(
          set, index, source, workspace, result,
          [&](DensitiesAt<Set>& densities) {
            densities.expect_all();
            MixtureSum<T, is_log_set<Set>> mixture;
            for (std::size_t k = 0; k < proposal_count; ++k) {
              const T density = densities.keep(k);
              // The density of a proposal without samples is multiplied by 0: the sum stays as it
              // is unless the density is at fault. In logarithms only those at fault are added: one
              // far above the others would displace their sum.
              if constexpr (is_log_set<Set>)
                if (counts[k] == 0 && density < std::numeric_limits<T>::infinity()) continue;
              mixture.add(density, static_cast<T>(counts[k]));
            }
            densities.count(proposal_count);
            return OwnAndDenominator<Set>{DensitiesAt<Set>::as_denominator(densities.kept(index)),
                                          mixture.over(as_factor<T>(total))};
          },
          [] {}, hand_over);
    }
  return result;
}
template <class Set, UniformSource Source, class Visit>
requires ProposalSet<Set, Source> RoundCounts sample_counted_round(const Set& set, CountsByProposal counts,
                                                                   Source& source, CountedWorkspace<Set>& workspace,
                                                                   Visit&& visit) {
  return sample_counted_round(set, counts, source, workspace, visit, [](std::size_t, std::uint32_t) {});
}

}  // namespace gmis
