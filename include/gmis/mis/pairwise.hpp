#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/weight_heuristic.hpp"

/// \file
/// Pairwise weights for many proposals [Bitterli: Correlations and reuse for fast and accurate physically based light
/// transport, 2022]. Each proposal k is weighed against a canonical one c alone: with d = n q and K = N − 1,
/// w_k = (1/K) d_k/(d_k + d_c/K), and w_c = (1/K) Σ_k (d_c/K)/(d_k + d_c/K). They sum to one where d_c > 0. A sample of k costs
/// two densities, one of c all N: 2 (n − n_c) + N n_c a round in place of N n.

namespace gmis {

/// The weights as a `WeightHeuristic`, for their exact variance.
struct Pairwise {
  std::size_t canonical = 0;  ///< number of the canonical proposal

  /// The weights of all proposals at one point, from densities relative to the mixture.
  void weights(CountsByProposal counts, std::span<const double> densities, std::span<double> out) const noexcept {
    const std::size_t n = out.size();
    const double others = static_cast<double>(n - 1);
    const double of_canonical = counts[canonical] * densities[canonical];
    if (n == 1) {
      out[0] = of_canonical > 0.0 ? 1.0 : 0.0;
      return;
    }
    out[canonical] = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      if (k == canonical) continue;
      const double own = counts[k] * densities[k], sum = own + of_canonical / others;
      out[k] = sum > 0.0 ? own / sum / others : 0.0;
      if (sum > 0.0) out[canonical] += of_canonical / others / sum / others;
    }
  }
  constexpr void require_fits(CountsByProposal counts) const {
    require_argument(canonical < counts.size() && counts[canonical] > 0,
                     "the canonical proposal must be one of the set and have samples");
  }
};

/// Draws one round with pairwise weights, each proposal k making counts[k] samples, and calls
/// `visit(x, denominator, index)`; (1/n) Σ f/denominator estimates ∫ f, n = Σ counts. Unbiased when the canonical proposal
/// has samples and is positive wherever f ≠ 0. `counts` must have passed `checked_total`.
template <class Set, UniformSource Source, class Visit>
requires ProposalSet<Set, Source> RoundCounts sample_pairwise_round(const Set& set, CountsByProposal counts,
                                                                    std::size_t canonical, Source& source,
                                                                    CountedWorkspace<Set>& workspace, Visit&& visit) {
  using T = typename Set::Density;
  const std::size_t n = set.size();
  const T others = n > 1 ? as_factor<T>(n - 1) : T(1);
  workspace.prepare(n, 0);
  std::size_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  const T of_canonical = static_cast<T>(counts[canonical]);

  RoundCounts result;
  for (std::size_t index = 0; index < n; ++index) {
    const T own_count = static_cast<T>(counts[index]);
    for (std::uint32_t i = 0; i < counts[index]; ++i)
      visit_sample<false>(
          set, index, source, workspace, result,
          [&](DensitiesAt<Set>& densities) {
            MixtureSum<T, is_log_set<Set>> denominator;
            const T own = densities[index];
            if (index != canonical) {  // n q/(n_k w): K (d_k + d_c/K)/n
              denominator.add(own, own_count * others);
              denominator.add(densities[canonical], of_canonical);
            } else {
              // w_c/(n_c q_c) = (1/K²) Σ_k 1/(d_k + d_c/K), here in units of 1/q_c.
              densities.expect_all();
              T inverse(0);
              for (std::size_t k = 0; k < n; ++k) {
                if (k == canonical && n > 1) continue;
                T expected(0);  // d_k/q_c
                if (k != canonical && counts[k] > 0) {
                  if constexpr (is_log_set<Set>)
                    expected = static_cast<T>(counts[k]) * std::exp(densities[k] - own);
                  else
                    expected = static_cast<T>(counts[k]) * (densities[k] / own);
                }
                inverse += T(1) / (expected + of_canonical / others);
              }
              denominator.add(own, others * others / inverse);
            }
            return OwnAndDenominator<Set>{DensitiesAt<Set>::as_denominator(own), denominator.over(as_factor<T>(total))};
          },
          [] {}, visit);
  }
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
