#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/methods/weight_heuristic.hpp"

/// \file
/// Pairwise weights for many proposals [Bitterli: Correlations and reuse for fast and accurate
/// physically based light transport, 2022; Lin et al.: Generalized resampled importance sampling,
/// 2022, eq. 37; with counts as in eq. 7.8 of Wyman et al.: A gentle introduction to ReSTIR, 2023,
/// without its defensive term]. Each proposal k is weighed against a canonical one c alone, and
/// stands for all the others there: with d = n q and a_k = n_k/(n − n_c), w_k = a_k d_k/(d_k + a_k
/// d_c), and w_c = Σ_k a_k² d_c/(d_k + a_k d_c). They sum to one where d_c > 0. A sample of k costs
/// two densities, one of c all N: 2 (n − n_c) + N n_c a round in place of N n.

namespace gmis {

/// The weights as a `WeightHeuristic`, for their exact variance.
struct Pairwise {
  std::size_t canonical = 0;  ///< number of the canonical proposal

  /// The weights of all proposals at one point, from densities relative to the mixture.
  void weights(CountsByProposal counts, std::span<const double> densities, std::span<double> out) const noexcept {
    double others = 0.0;
    for (std::size_t k = 0; k < out.size(); ++k)
      if (k != canonical) others += counts[k];
    const double of_canonical = counts[canonical] * densities[canonical];
    out[canonical] = others > 0.0 || !(of_canonical > 0.0) ? 0.0 : 1.0;
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (k == canonical) continue;
      const double share = others > 0.0 ? counts[k] / others : 0.0;
      const double own = counts[k] * densities[k], sum = own + share * of_canonical;
      out[k] = sum > 0.0 ? share * (own / sum) : 0.0;
      if (sum > 0.0) out[canonical] += share * (share * of_canonical / sum);
    }
  }
  constexpr void require_fits(CountsByProposal counts) const {
    require_argument(canonical < counts.size() && counts[canonical] > 0,
                     "the canonical proposal must be one of the set and have samples");
  }
};

/// Draws one round with pairwise weights, each proposal k making counts[k] samples, and calls
/// `visit(x, denominator, index)`; (1/n) Σ f/denominator estimates ∫ f, n = Σ counts. Unbiased when
/// the canonical proposal has samples and is positive wherever f ≠ 0. `counts` must have passed
/// `checked_total`.
template <class Set, UniformSource Source, class Visit>
requires ProposalSet<Set, Source> RoundCounts sample_pairwise_round(const Set& set, CountsByProposal counts,
                                                                    std::size_t canonical, Source& source,
                                                                    CountedWorkspace<Set>& workspace, Visit&& visit) {
  using T = typename Set::Density;
  const std::size_t n = set.size();
  workspace.prepare(n, 0);
  std::size_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  const T of_canonical = static_cast<T>(counts[canonical]);
  const std::size_t other_samples = total - counts[canonical];
  const T others = as_factor<T>(other_samples);

  RoundCounts result;
  for (std::size_t index = 0; index < n; ++index)
    for (std::uint32_t i = 0; i < counts[index]; ++i)
      visit_sample<false>(
          set, index, source, workspace, result,
          [&](DensitiesAt<Set>& densities) {
            MixtureSum<T, is_log_set<Set>> denominator;
            const T own = densities[index];
            T normaliser = as_factor<T>(total);
            if (index != canonical) {  // n q/(n_k w): ((n − n_c) q_k + n_c q_c)/n
              denominator.add(own, others);
              denominator.add(densities[canonical], of_canonical);
            } else if (other_samples == 0) {
              denominator.add(own);
              normaliser = T(1);
            } else {
              // w_c/(n_c q_c) = Σ_k a_k/((n − n_c) q_k + n_c q_c), here in units of 1/q_c.
              densities.expect_all();
              T inverse(0);
              for (std::size_t k = 0; k < n; ++k) {
                if (k == canonical || counts[k] == 0) continue;
                T expected;  // q_k/q_c
                if constexpr (is_log_set<Set>)
                  expected = std::exp(densities[k] - own);
                else
                  expected = densities[k] / own;
                inverse += static_cast<T>(counts[k]) / others / (others * expected + of_canonical);
              }
              denominator.add(own, T(1) / inverse);
            }
            return OwnAndDenominator<Set>{DensitiesAt<Set>::as_denominator(own), denominator.over(normaliser)};
          },
          [] {}, visit);
  return result;
}

/// Estimates ∫ f with `rounds` ≥ 1 rounds of pairwise weights. As `estimate`, otherwise.
template <class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_pairwise(Integrand&& f, const P& proposals, CountsByProposal counts,
                                         std::size_t canonical, std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  const std::size_t total = checked_total(counts, set.size());
  require_rounds(rounds);
  require_fits(Pairwise{canonical}, counts);
  CountedWorkspace<Set> workspace;
  EstimateAccumulator<F> accumulator;
  for (std::uint64_t round = 0; round < rounds; ++round)
    accumulator.add_round(f, total, [&](auto&& visit) {
      return sample_pairwise_round(set, counts, canonical, source, workspace, visit);
    });
  return accumulator.result();
}

}  // namespace gmis
