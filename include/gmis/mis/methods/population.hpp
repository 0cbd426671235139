#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/methods/reservoir.hpp"

namespace gmis {

/// Where the samples come from that a proposal may move to: its own samples, or those of all.
enum class Relocation : std::uint8_t { local, global };

/// Population Monte Carlo with deterministic-mixture weights [Elvira, Martino, Luengo, Bugallo:
/// Improving population Monte Carlo: alternative weighting and resampling schemes, 2017]: in every
/// iteration each proposal makes `samples_each` samples, weighted by the mixture of all of them
/// (N3), and each proposal then moves to a sample drawn in proportion to |weight| from its own
/// samples (local resampling, which keeps the population spread) or from all (global).
///
/// `move(proposal, x)` returns the proposal moved to x. The mean over iterations is unbiased: given
/// the past, every iteration is an N3 round. Iterations are uncorrelated but not equally
/// distributed: the standard error is unbiased in square, and `variance` is the mean over
/// iterations. The proposals end up in `proposals`.
template <class Integrand, class P, class Move, class Source>
requires(detail::explain_arguments<Integrand, std::vector<P>, Source>())
    [[nodiscard]] auto estimate_population(Integrand&& f, std::vector<P>& proposals, std::uint32_t samples_each,
                                           std::uint64_t iterations, Move&& move, Source& source,
                                           Relocation relocation = Relocation::local) {
  using X = ValueOf<P, Source>;
  using F = SummandOf<Integrand, X>;
  using A = typename EstimateAccumulator<F>::A;
  const std::size_t n = proposals.size();
  const std::vector<std::uint32_t> counts(n, samples_each);
  const std::size_t total = checked_total(counts, n);
  require_rounds(iterations);
  EstimateAccumulator<F> moments;
  for (std::uint64_t iteration = 0; iteration < iterations; ++iteration) {
    const auto set = as_proposal_set<Source>(proposals);
    CountedWorkspace<std::remove_cvref_t<decltype(set)>> workspace;
    typename EstimateAccumulator<F>::Channels sum{};
    // One reservoir for each proposal: local ones hear of its own samples, global ones of all.
    std::vector<Reservoir<X>> chosen(n);
    const RoundCounts cost =
        sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto, std::size_t index) {
          const auto value = moments.quotient(value_of(f, x), psi);
          double weight = 0.0;
          for (std::size_t c = 0; c < sum.size(); ++c) {
            sum[c] += value[c] / static_cast<A>(total);
            weight += std::abs(static_cast<double>(value[c]));
          }
          if (relocation == Relocation::local)
            (void)chosen[index].add(x, weight, source);
          else
            for (Reservoir<X>& reservoir : chosen) (void)reservoir.add(x, weight, source);
        });
    moments.add_estimate(sum, total, cost);
    for (std::size_t k = 0; k < n; ++k)
      if (chosen[k].sample()) proposals[k] = move(proposals[k], *chosen[k].sample());
  }
  return moments.result();
}

}  // namespace gmis
