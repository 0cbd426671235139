#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/weight_heuristic.hpp"

namespace gmis {

/// Factors for `ScaledBalance` where the samples of a proposal are correlated, as those of paths that share a prefix are
/// [Grittmann, Georgiev, Slusallek: Correlation-aware multiple importance sampling for bidirectional rendering algorithms,
/// 2021]. The mean of n_k samples with correlation ρ_k between any two has the variance of n_k/(1 + (n_k − 1) ρ_k)
/// independent ones; that effective count stands in for n_k in the weights: factor 1/(1 + (n_k − 1) ρ_k). ρ = 0 is the
/// balance heuristic, ρ = 1 counts all samples of a proposal as one. Contributions still divide by the true n_k.
///
/// `correlations`: ρ_k in [0, 1], one for each proposal, estimated by the caller.
[[nodiscard]] inline std::vector<double> correlation_aware_factors(CountsByProposal counts,
                                                                   std::span<const double> correlations) {
  if (correlations.size() != counts.size()) reject_argument("give one correlation for each proposal");
  std::vector<double> factors(counts.size(), 1.0);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (!(correlations[k] >= 0.0 && correlations[k] <= 1.0)) reject_argument("a correlation must lie between 0 and 1");
    if (counts[k] > 0) factors[k] = 1.0 / (1.0 + (counts[k] - 1.0) * correlations[k]);
  }
  return factors;
}

}  // namespace gmis
