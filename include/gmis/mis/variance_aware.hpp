#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "gmis/mis/weight_heuristic.hpp"

namespace gmis {

/// Factors v_k for `ScaledBalance` that make weights variance-aware [Grittmann, Georgiev, Slusallek, Křivánek:
/// Variance-aware multiple importance sampling, 2019]: v_k = E[y²]/Var[y], y the balance-weighted contribution f/Σ n q of a
/// sample of proposal k. The balance heuristic minimises the second moments; a proposal whose second moment is mostly its
/// squared mean makes little noise, and deserves more weight. Factors only change weights: every choice is unbiased.
///
/// From a quadrature rule or a pilot. A proposal without variance gets `largest`, one that never contributes 1.
[[nodiscard]] inline std::vector<double> variance_aware_factors(CountsByProposal counts,
                                                                const TabulatedProblem& problem, double largest = 1e6) {
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  std::vector<double> factors(counts.size(), 1.0);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    const double* const q = problem.densities(k);
    double mass = 0.0, mean = 0.0;
    for (std::size_t i = 0; i < psi.size(); ++i) {
      if (!(q[i] > 0.0)) continue;
      mass += problem.weights()[i] * q[i];
      mean += problem.weights()[i] * q[i] * (problem.values()[i] / psi[i]);
    }
    double variance = std::max(0.0, 1.0 - mass) * mean * mean;
    for (std::size_t i = 0; i < psi.size(); ++i) {
      if (!(q[i] > 0.0)) continue;
      const double difference = problem.values()[i] / psi[i] - mean;
      variance += problem.weights()[i] * q[i] * difference * difference;
    }
    const double second = variance + mean * mean;
    if (second > 0.0) factors[k] = variance * largest > second ? second / variance : largest;
  }
  return factors;
}

}  // namespace gmis
