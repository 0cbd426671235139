#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/methods/weight_heuristic.hpp"

namespace gmis {

namespace detail {
/// E[y²]/Var[y] = 1 + E[y]²/Var[y] of y = f/divisor under proposal k, at most `largest`; 1 where y
/// is zero or its variance is infinite. A sample that is not made counts as y = 0.
[[nodiscard]] inline double moment_over_variance(const TabulatedProblem& problem, std::size_t k, const double* divisor,
                                                 double largest) {
  const double* const q = problem.densities(k);
  const auto value = [&](std::size_t i) { return problem.values()[i] / divisor[i]; };
  const double mean = mean_under(problem, q, value), variance = variance_under(problem, q, mean, value);
  const double second = variance + mean * mean;
  if (!(second > 0.0 && std::isfinite(second))) return 1.0;
  return variance * largest > second ? second / variance : largest;
}
}  // namespace detail

/// Factors v_k for `ScaledBalance` that make weights variance-aware [Grittmann, Georgiev,
/// Slusallek, Křivánek: Variance-aware multiple importance sampling, 2019]: v_k = E[y²]/Var[y] =
/// 1 + E[y]²/Var[y], y = f/q_k being what proposal k contributes *alone*. The balance heuristic
/// minimises second moments; a proposal whose second moment is mostly its squared mean makes little
/// noise, and deserves more weight. Factors only change weights: every choice is unbiased.
///
/// From a quadrature rule or a pilot. A proposal without variance gets `largest` (the authors'
/// program clamps at 16), one that never contributes, or whose variance is infinite, 1.
[[nodiscard]] inline std::vector<double> variance_aware_factors(const TabulatedProblem& problem, double largest = 1e6) {
  require_argument(largest >= 1.0, "the largest factor must be 1 or more");
  std::vector<double> factors(problem.proposal_count());
  for (std::size_t k = 0; k < factors.size(); ++k)
    factors[k] = detail::moment_over_variance(problem, k, problem.densities(k), largest);
  return factors;
}

/// The same ratio for y = f/Σ n q, what a sample of k contributes *under the balance heuristic with
/// these counts*. The paper's figures use `variance_aware_factors`; these factors are close to what
/// the resulting weights ask for, and finite where f/q_k is not. A proposal without samples gets 1.
[[nodiscard]] inline std::vector<double> variance_aware_factors_of_balance(CountsByProposal counts,
                                                                           const TabulatedProblem& problem,
                                                                           double largest = 1e6) {
  require_argument(largest >= 1.0, "the largest factor must be 1 or more");
  (void)checked_total(counts, problem.proposal_count());
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  std::vector<double> factors(counts.size(), 1.0);
  for (std::size_t k = 0; k < counts.size(); ++k)
    if (counts[k] > 0) factors[k] = detail::moment_over_variance(problem, k, psi.data(), largest);
  return factors;
}

}  // namespace gmis
