#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/methods/reservoir.hpp"

/// \file
/// Resampled importance sampling [Talbot, Cline, Egbert 2005]: many cheap candidates, of which one
/// is kept in proportion to a target p̂ that resembles f, and only that one sees f. It pays where f
/// costs far more than p̂.

namespace gmis {

/// Draws the candidates of one round, n_k of each proposal, weights them by p̂/(Σ n q) (balance
/// heuristic) and keeps one. f(y) W is an unbiased estimate of ∫ f where p̂ > 0 and some n_k q_k >
/// 0 wherever f ≠ 0. `target(x)` is p̂(x) ≥ 0. A candidate is left out, and counted in
/// `cost.non_finite_density`, where p̂ is negative or not finite, or p̂/(Σ n q) is not finite.
template <class Target, class Set, UniformSource Source>
requires ProposalSet<Set, Source>
[[nodiscard]] Reservoir<typename Set::Value> resample(Target&& target, const Set& set, CountsByProposal counts,
                                                      Source& source, CountedWorkspace<Set>& workspace,
                                                      RoundCounts& cost) {
  Reservoir<typename Set::Value> reservoir;
  std::size_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  double chosen_target = 0.0;
  const RoundCounts spent =
      sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto, std::size_t) {
        const double value = static_cast<double>(target(x));
        if (reservoir.add(x, ratio<double>(value, psi) / static_cast<double>(total), source)) chosen_target = value;
      });
  cost.density_evaluations += spent.density_evaluations;
  cost.failed_samples += spent.failed_samples;
  cost.zero_density += spent.zero_density;
  cost.non_finite_density += spent.non_finite_density + reservoir.rejected();
  reservoir.finish(chosen_target, static_cast<double>(total));
  return reservoir;
}

/// Estimates ∫ f with `rounds` ≥ 1 rounds of resampling; each evaluates f once, and the target and
/// all densities for each of its Σ n_k candidates (the `samples` of the result). Candidates with a
/// target that is negative or not finite are left out, which biases the mean: they count as
/// `rejected.non_finite_density`.
template <class Integrand, class Target, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_resampled(Integrand&& f, Target&& target, const P& proposals, CountsByProposal counts,
                                          std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  const std::size_t total = checked_total(counts, set.size());
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    RoundCounts cost;
    const auto reservoir = resample(target, set, counts, source, workspace, cost);
    typename EstimateAccumulator<F>::Channels value{};
    if (reservoir.contribution_weight() > 0.0)
      value = moments.quotient(value_of(f, *reservoir.sample()), 1.0 / reservoir.contribution_weight());
    moments.add_estimate(value, total, cost);
  }
  return moments.result();
}

/// Mean and variance of one round of resampling, `target` being p̂ at the nodes. With u = p̂/(Σ n
/// q), h = f/p̂ and U the sum of all u: the estimate is h(y) U, and E[h²(y) U²] = E[U Σ u h²] = Σ
/// n_k E_k[u² h²] + (Σ n_k E_k[u]) (Σ n_k E_k[u h²]) − Σ n_k E_k[u] E_k[u h²].
[[nodiscard]] inline ExactMoments exact_moments_of_resampling(CountsByProposal counts, std::span<const double> target,
                                                              const TabulatedProblem& problem) {
  const double total = static_cast<double>(checked_total(counts, problem.proposal_count()));
  if (target.size() != problem.node_count()) reject_argument("give the target at every node");
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  double mean = 0.0, second = 0.0, sum_u = 0.0, sum_uhh = 0.0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    double u_mean = 0.0, uhh_mean = 0.0;
    for (std::size_t i = 0; i < psi.size(); ++i) {
      const double q = problem.densities(k)[i];
      if (!(q > 0.0 && target[i] > 0.0)) continue;
      const double weight = problem.weights()[i] * q, expected = psi[i] * total, f = problem.values()[i];
      mean += counts[k] * weight * (f / expected);
      second += counts[k] * weight * (f / expected) * (f / expected);
      u_mean += weight * (target[i] / expected);
      uhh_mean += weight * (f / expected) * (f / target[i]);
    }
    sum_u += counts[k] * u_mean;
    sum_uhh += counts[k] * uhh_mean;
    second -= counts[k] * u_mean * uhh_mean;
  }
  return {mean, detail::variance_from(second + sum_u * sum_uhh, mean * mean)};
}

}  // namespace gmis
