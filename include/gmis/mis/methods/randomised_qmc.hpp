#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/methods/scrambled_sobol.hpp"

namespace gmis {

/// A uniform source made of points: `start_round(round)` draws a new randomisation,
/// `start_sample(stream, index)` moves to the first coordinate of a point. `ScrambledSobol` is one.
template <class S>
concept PointSource = UniformSource<S> && requires(S& source, std::uint64_t number, std::uint32_t index) {
  source.start_round(number);
  source.start_sample(number, index);
};

/// Estimates ∫ f by randomised quasi-Monte Carlo over N3 with counts: the n_k samples of proposal k
/// are the first n_k points of its own stream, best a power of two, and a round is a randomisation.
/// Points within a round are dependent, so the error comes from the spread between rounds: `rounds`
/// ≥ 2, better 8 or more. Unbiased as N3 is, for every n_k.
///
/// Samplers must be smooth functions of their random numbers and use the same number of them in the
/// same order for every sample: inversion does; rejection and tables with jumps gain little.
template <class Integrand, class P, PointSource Points>
requires(detail::explain_arguments<Integrand, P, Points>())
    [[nodiscard]] auto estimate_rqmc(Integrand&& f, const P& proposals, CountsByProposal counts, std::uint64_t rounds,
                                     Points& points) {
  const auto& set = as_proposal_set<Points>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  using A = typename EstimateAccumulator<F>::A;
  const std::size_t total = checked_total(counts, set.size());
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    points.start_round(round);
    typename EstimateAccumulator<F>::Channels sum{};
    const RoundCounts cost = sample_counted_round(
        set, counts, points, workspace,
        [&](const auto& x, auto psi, auto, std::size_t) {
          const auto value = moments.quotient(value_of(f, x), psi);
          for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += value[c];
        },
        [&](std::size_t k, std::uint32_t i) { points.start_sample(k, i); });
    for (A& channel : sum) channel /= static_cast<A>(total);
    moments.add_estimate(sum, total, cost);
  }
  return moments.result();
}

}  // namespace gmis
