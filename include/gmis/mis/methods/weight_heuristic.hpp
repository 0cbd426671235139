#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/heuristic.hpp"

namespace gmis {

/// Weights from all densities at a point and all counts: `weights(counts, densities, out)` fills
/// `out` with numbers that sum to one wherever some n_k q_k > 0. The densities come relative to the
/// mixture ψ of the counts, so that they are in range; a heuristic must not depend on a common
/// factor of them. It is called once a sample: it must not allocate. It may have
/// `require_fits(counts)`, which is called once before all samples and throws std::invalid_argument
/// when the heuristic is made for other proposals.
template <class H>
concept WeightHeuristic = requires(const H& heuristic, CountsByProposal counts, std::span<const double> densities,
                                   std::span<double> out) {
  heuristic.weights(counts, densities, out);
};

/// Checks a heuristic that can be checked, once for all samples.
template <WeightHeuristic H>
constexpr void require_fits(const H& heuristic, CountsByProposal counts) {
  if constexpr (requires { heuristic.require_fits(counts); }) heuristic.require_fits(counts);
}

/// `Balance`, `Power`, `Cutoff`, `Maximum`, or any function of one ratio, as a `WeightHeuristic`.
template <Heuristic H>
struct RatioWeights {
  H heuristic;  ///< turns each ratio of densities into a weight

  /// The weights of all proposals at one point, from densities relative to the mixture.
  void weights(CountsByProposal counts, std::span<const double> densities, std::span<double> out) const noexcept {
    heuristic_weights(heuristic, counts, densities, out);
  }
  constexpr void require_fits(CountsByProposal) const { require_heuristic(heuristic); }
};

/// w_k = e_k n_k q_k / Σ e_j n_j q_j: the balance heuristic with expected densities scaled by
/// `factors` e_k > 0. Variance-aware and correlation-aware weights are of this form.
struct ScaledBalance {
  std::vector<double> factors;  ///< one for each proposal, positive where it has samples

  /// The weights of all proposals at one point, from densities relative to the mixture.
  void weights(CountsByProposal counts, std::span<const double> densities, std::span<double> out) const noexcept {
    double sum = 0.0;
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = factors[k] * (counts[k] * densities[k]);
      sum += out[k];
    }
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = sum > 0.0 ? out[k] / sum : 0.0;
  }
  void require_fits(CountsByProposal counts) const {
    require_argument(factors.size() == counts.size(), "give one factor for each proposal");
    for (std::size_t k = 0; k < factors.size(); ++k)
      require_argument(factors[k] <= std::numeric_limits<double>::max() && (factors[k] > 0.0 || counts[k] == 0),
                       "the factors of proposals with samples must be positive and finite");
  }
};

/// Estimates ∫ f with `rounds` ≥ 1 rounds of the multi-sample form Σ_k (1/n_k) Σ_i w_k f/q_k under
/// `heuristic`. N evaluations of densities a sample. Unbiased when the weights of the proposals
/// with samples sum to one wherever f ≠ 0.
template <WeightHeuristic H, class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_with_weights(const H& heuristic, Integrand&& f, const P& proposals,
                                             CountsByProposal counts, std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  using A = typename EstimateAccumulator<F>::A;
  const std::size_t n = set.size();
  const std::size_t total = checked_total(counts, n);
  require_rounds(rounds);
  require_fits(heuristic, counts);
  std::vector<double> densities(n), weights(n);
  EstimateAccumulator<F> moments;
  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    typename EstimateAccumulator<F>::Channels sum{};
    const RoundCounts cost = sample_counted_round(
        set, counts, source, workspace, [&](const auto& x, auto psi, auto relative, std::size_t index) {
          for (std::size_t k = 0; k < n; ++k) densities[k] = static_cast<double>(relative[k]);
          heuristic.weights(counts, densities, weights);
          if (weights[index] == 0.0) return;
          const auto value = moments.quotient(value_of(f, x), psi);
          const A factor = static_cast<A>(weights[index] / (counts[index] * densities[index]));
          for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += factor * value[c];
        });
    moments.add_estimate(sum, total, cost);
  }
  return moments.result();
}

/// Mean and variance of one round of `estimate_with_weights`. The mean shows whether the weights
/// sum to one. Throws std::invalid_argument for a weight that is not finite where it is used.
template <WeightHeuristic H>
[[nodiscard]] ExactMoments exact_moments_with_weights(const H& heuristic, CountsByProposal counts,
                                                      const TabulatedProblem& problem) {
  const std::size_t n = problem.proposal_count(), nodes = problem.node_count();
  (void)checked_total(counts, n);
  require_fits(heuristic, counts);
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  std::vector<double> densities(n), weights(n), contributions(n * nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    if (!(psi[i] > 0.0)) continue;
    for (std::size_t k = 0; k < n; ++k) densities[k] = problem.densities(k)[i] / psi[i];
    heuristic.weights(counts, densities, weights);
    for (std::size_t k = 0; k < n; ++k)
      if (densities[k] > 0.0 && counts[k] > 0) {
        require_argument(std::isfinite(weights[k]), "a weight of the heuristic is not finite");
        contributions[k * nodes + i] = weights[k] / (counts[k] * densities[k]) * (problem.values()[i] / psi[i]);
      }
  }
  return moments_of_contributions(problem, counts,
                                  [&](std::size_t k, std::size_t i) { return contributions[k * nodes + i]; });
}

}  // namespace gmis
