#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/mis/diagnostics/best_scheme.hpp"
#include "gmis/mis/methods/optimal_allocation.hpp"

namespace gmis {

/// A way to draw rounds, with what the pilot says of it: a candidate of `best_scheme` (one sample
/// of each proposal), or N3 or R3 with a sample allocation.
struct PlanCandidate {
  SchemeCandidate round;                ///< scheme, group size, variance, cost of one round
  std::vector<std::uint32_t> counts{};  ///< n_k of N3; empty: one sample of each proposal
  std::vector<double> fractions{};      ///< α_k of R3; empty: equal
};

/// The candidates, and which is best.
struct PlanChoice {
  std::vector<PlanCandidate> candidates;  ///< those of `best_scheme`, then N3 with counts, then R3 with fractions
  std::size_t best;                       ///< the unbiased one with the least variance × cost

  /// The best one.
  [[nodiscard]] const PlanCandidate& chosen() const& noexcept { return candidates[best]; }
  /// The best one.
  [[nodiscard]] PlanCandidate chosen() const&& { return candidates[best]; }
};

/// Scheme, group size P and sample allocation from one pilot (or one quadrature rule), by variance
/// × cost. The allocations have `samples` samples a round; a proposal without samples costs no
/// density evaluations. Throws as `best_scheme` and `optimal_counts` do.
template <UniformSource Source>
[[nodiscard]] PlanChoice best_plan(const TabulatedProblem& problem, const CostModel& costs, std::size_t samples,
                                   Source& source, std::uint64_t averaged_draws = 32) {
  PlanChoice choice{{}, 0};
  const SchemeChoice schemes = best_scheme(problem, costs, source, averaged_draws);
  for (const SchemeCandidate& candidate : schemes.candidates) choice.candidates.push_back({candidate, {}, {}});
  choice.best = schemes.best;

  const auto add = [&](Scheme scheme, double variance, std::size_t used, std::vector<std::uint32_t> counts,
                       std::vector<double> fractions) {
    const double evaluations = static_cast<double>(samples) * static_cast<double>(used);
    const SchemeCandidate round{
        scheme,   0,           true,
        variance, evaluations, evaluations * costs.per_density + static_cast<double>(samples) * costs.per_sample};
    choice.candidates.push_back({round, std::move(counts), std::move(fractions)});
    const double score = round.variance_times_cost();
    if (score < (1.0 - 1e-9) * choice.chosen().round.variance_times_cost()) choice.best = choice.candidates.size() - 1;
  };
  const auto used = [](const auto& amounts) {
    return static_cast<std::size_t>(std::count_if(amounts.begin(), amounts.end(), [](auto a) { return a > 0; }));
  };
  std::vector<std::uint32_t> counts = optimal_counts(problem, samples);
  const double of_counts = exact_moments(CountsByProposal(counts), problem).variance;
  add(Scheme::N3, of_counts, used(counts), counts, {});
  std::vector<double> fractions = optimal_fractions(problem);
  for (double& fraction : fractions)
    if (fraction < 1e-6) fraction = 0.0;
  double sum = 0.0;
  for (const double fraction : fractions) sum += fraction;
  for (double& fraction : fractions) fraction /= sum;
  if (problem.covers(mixture_of(fractions, problem).data()))
    add(Scheme::R3, exact_moments_of_mixture(fractions, samples, problem).variance, used(fractions), {}, fractions);
  return choice;
}

}  // namespace gmis
