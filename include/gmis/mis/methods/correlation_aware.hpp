#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/methods/weight_heuristic.hpp"

/// \file
/// Weights for proposals whose samples are correlated, as those of paths that share a prefix are
/// [Grittmann, Georgiev, Slusallek: Correlation-aware multiple importance sampling for
/// bidirectional rendering algorithms, 2021]: the balance heuristic with c_k n_k in place of n_k,
/// c_k from 1 (independent samples) down to 1/n_k (all of them as good as one). Contributions still
/// divide by the true n_k, so that every c is unbiased.

namespace gmis {

/// Factors c_k for `ScaledBalance` where the correlation ρ_k between any two samples of proposal k
/// is known. The mean of n_k such samples has the variance of n_k/(1 + (n_k − 1) ρ_k) independent
/// ones (Kish's design effect), so that c_k = 1/(1 + (n_k − 1) ρ_k). ρ = 0 is the balance
/// heuristic.
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

/// The factor c for one path, by the heuristic of the paper, where `count` samples share a prefix
/// and nobody knows their correlation: c = max(1/count, P/(P + Q − P Q)), as in the authors'
/// program. P is the probability that the shared part, drawn anew, comes to about the same place; Q
/// that the part drawn for each sample does. Where the prefix is the less likely of the two, a hit
/// depends on it, and all samples hit or miss together: c is small. The program's probabilities are
/// Π min(1, p_i A) over the vertices of the part, p_i their densities per area, A the area of a
/// disk that is seen from the camera under a radius of 1°. 0 for P and Q gives 1.
[[nodiscard]] constexpr double correlation_aware_factor(std::uint32_t count, double prefix_probability,
                                                        double rest_probability) {
  require_argument(count > 0, "a correlation needs at least one sample");
  require_argument(
      prefix_probability >= 0.0 && prefix_probability <= 1.0 && rest_probability >= 0.0 && rest_probability <= 1.0,
      "probabilities lie between 0 and 1");
  if (prefix_probability == 0.0 && rest_probability == 0.0) return 1.0;
  const double either = prefix_probability + rest_probability * (1.0 - prefix_probability);
  return std::max(1.0 / count, prefix_probability / either);
}

}  // namespace gmis
