#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"

namespace gmis {

namespace detail {
/// E h(x), x ~ q: sums `value(i)`, h at node i, over the nodes with q > 0. Values that are not
/// finite are left out.
template <class Value>
[[nodiscard]] double mean_under(const TabulatedProblem& problem, const double* q, Value value) {
  double mean = 0.0;
  for (std::size_t i = 0; i < problem.node_count(); ++i)
    if (q[i] > 0.0)
      if (const double h = value(i); std::isfinite(h)) mean += problem.weights()[i] * q[i] * h;
  return mean;
}
/// Var h(x), about its mean, so that nothing cancels. What is missing of the mass of q is samples
/// that fail, and contribute zero.
template <class Value>
[[nodiscard]] double variance_under(const TabulatedProblem& problem, const double* q, double mean, Value value) {
  double mass = 0.0;
  for (std::size_t i = 0; i < problem.node_count(); ++i)
    if (q[i] > 0.0) mass += problem.weights()[i] * q[i];
  double variance = std::max(0.0, 1.0 - mass) * mean * mean;
  for (std::size_t i = 0; i < problem.node_count(); ++i) {
    if (!(q[i] > 0.0)) continue;
    const double difference = value(i) - mean;
    variance += problem.weights()[i] * q[i] * difference * difference;
  }
  return variance_from(variance, 0.0);
}
}  // namespace detail

/// Mean and variance of Σ_k Σ_{i ≤ n_k} h_k(x_ki), x_ki ~ q_k independent: Σ n_k E h_k and Σ n_k
/// Var h_k. Every estimator that gives proposal k a fixed number of samples and weights each by a
/// function of the sample alone is of this form. `contribution(k, i)` is h_k at node i, asked for
/// only where q_k > 0. One that is not finite makes the variance infinite and is left out of the
/// mean.
template <class Contribution>
[[nodiscard]] ExactMoments moments_of_contributions(const TabulatedProblem& problem, CountsByProposal counts,
                                                    Contribution contribution) {
  (void)checked_total(counts, problem.proposal_count());
  ExactMoments moments{0.0, 0.0};
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    const auto value = [&](std::size_t i) { return contribution(k, i); };
    const double* const q = problem.densities(k);
    const double mean = detail::mean_under(problem, q, value);
    moments.mean += counts[k] * mean;
    moments.variance += counts[k] * detail::variance_under(problem, q, mean, value);
  }
  return moments;
}

/// α_k = n_k / Σ n_k.
[[nodiscard]] inline std::vector<double> fractions_of(CountsByProposal counts) {
  const double total = static_cast<double>(checked_total(counts, counts.size()));
  std::vector<double> fractions(counts.begin(), counts.end());
  for (double& fraction : fractions) fraction /= total;
  return fractions;
}

/// Mean and variance of one round of N3 with counts, (1/n) Σ f/ψ with ψ = Σ n_k q_k/n: variance
/// (1/n) ∫ f²/ψ − (1/n²) Σ n_k (∫ f q_k/ψ)². Holds for partial support too (the mean is then ∫ f
/// over the points that ψ covers).
[[nodiscard]] inline ExactMoments exact_moments(CountsByProposal counts, const TabulatedProblem& problem) {
  const double total = static_cast<double>(checked_total(counts, problem.proposal_count()));
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  const ExactMoments moments = moments_of_contributions(
      problem, counts, [&](std::size_t, std::size_t i) { return problem.values()[i] / psi[i] / total; });
  return {problem.covered_integral(psi.data()), moments.variance};  // Σ n_k q_k/(n ψ) is one: also where f/ψ overflows
}

/// Mean and variance of `samples` draws of R3 with fractions α_k: (1/n) (∫ f²/ψ − I²), ψ = Σ α_k
/// q_k.
[[nodiscard]] inline ExactMoments exact_moments_of_mixture(std::span<const double> fractions, std::size_t samples,
                                                           const TabulatedProblem& problem) {
  require_argument(samples > 0, "a round of no samples: ask for at least one");
  const std::vector<double> psi = mixture_of(fractions, problem);
  const double mean = problem.covered_integral(psi.data());
  const double variance =
      detail::variance_under(problem, psi.data(), mean, [&](std::size_t i) { return problem.values()[i] / psi[i]; });
  return {mean, variance / static_cast<double>(samples)};
}

}  // namespace gmis
