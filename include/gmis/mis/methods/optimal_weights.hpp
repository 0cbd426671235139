#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gmis/mis/methods/control_variate.hpp"

/// \file
/// Optimal weights [Kondapaneni, Vévoda, Grittmann, Skřivan, Slusallek, Křivánek: Optimal multiple
/// importance sampling, 2019]. The estimator with weights free to be negative and to depend on f
/// has the least variance with control variates Σ β_k q_k that solve Σ_k β_k ∫ q_i q_k/ψ = ∫ f
/// q_i/ψ: their α is this β, their technique matrix and contribution vector the two sides over n
/// (ψ = Σ n q/n). Nothing but N3's evaluations is needed, and the variance is zero where f is a
/// combination of the densities.

namespace gmis {

/// The weights of all proposals at one point, w_k = β_k q_k/f + (n_k q_k/Σ n q) (1 − Σ β q/f)
/// [Kondapaneni et al. 2019]. They sum to one and may be negative. For study: the estimators below
/// never divide by f. `value` is f ≠ 0.
inline void optimal_weights(std::span<const double> coefficients, CountsByProposal counts,
                            std::span<const double> densities, double value, std::span<double> out) noexcept {
  double sum = 0.0, control = 0.0;
  for (std::size_t k = 0; k < densities.size(); ++k) {
    sum += counts[k] * densities[k];
    control += coefficients[k] * densities[k];
  }
  for (std::size_t k = 0; k < densities.size(); ++k)
    out[k] = coefficients[k] * densities[k] / value + counts[k] * densities[k] / sum * (1.0 - control / value);
}

/// The progressive estimator: each round uses coefficients fitted to the rounds before it, anew
/// whenever these have doubled. Unbiased where N3 is. The first rounds, until 4 N samples were
/// seen, serve the fit alone: they are in `samples`, not in `rounds`. `rounds` of the result is at
/// least 1; proposals must not fail.
template <class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_optimal_progressive(Integrand&& f, const P& proposals, CountsByProposal counts,
                                                    std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  using Channels = typename EstimateAccumulator<F>::Channels;
  using A = typename EstimateAccumulator<F>::A;
  static_assert(!set_can_fail<Set, Source>, "optimal weights need proposals that always make a sample");
  const std::size_t n = set.size();
  const std::size_t total = checked_total(counts, n);
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  ControlFit<F> fit(n);
  std::vector<double> coefficients;
  std::uint64_t next_fit = 4 * n;

  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    if (fit.samples() >= next_fit) {
      coefficients = fit.coefficients();
      next_fit = 2 * fit.samples();
    }
    const bool counts_for_mean = !coefficients.empty() || round + 1 == rounds;
    Channels sum{};
    const RoundCounts cost =
        sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto relative, std::size_t) {
          const Channels value = moments.quotient(value_of(f, x), psi);
          fit.add(relative, value);
          for (std::size_t c = 0; c < sum.size(); ++c) {
            A control(0);
            if (!coefficients.empty())
              for (std::size_t k = 0; k < n; ++k)
                control += static_cast<A>(coefficients[c * n + k]) * static_cast<A>(relative[k]);
            sum[c] += value[c] - control;
          }
        });
    if (!counts_for_mean) {
      moments.add_cost(total, cost);
      continue;
    }
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c] /= static_cast<A>(total);
      if (!coefficients.empty())
        for (std::size_t k = 0; k < n; ++k) sum[c] += static_cast<A>(coefficients[c * n + k]);
    }
    moments.add_estimate(sum, total, cost);
  }
  return moments.result();
}

/// The direct estimator: coefficients from all samples, applied to the same samples, which makes
/// the estimate Σ β_k where every proposal has samples. Its bias is of the order of variance/rounds
/// and vanishes against the standard error, which is that of the residuals between rounds,
/// corrected for the N coefficients. Proposals must not fail.
template <class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_optimal_direct(Integrand&& f, const P& proposals, CountsByProposal counts,
                                               std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  using Channels = typename EstimateAccumulator<F>::Channels;
  static_assert(!set_can_fail<Set, Source>, "optimal weights need proposals that always make a sample");
  const std::size_t n = set.size();
  const std::size_t total = checked_total(counts, n);
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  ControlFit<F> fit(n);

  // Means over a round of f/ψ in every channel and of every q_k/ψ; their means and products over
  // rounds.
  constexpr std::size_t channels = EstimateAccumulator<F>::channel_count;
  const std::size_t width = channels + n;
  std::vector<double> row(width), mean(width), products(width * width);
  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::fill(row.begin(), row.end(), 0.0);
    Channels sum{};
    const RoundCounts cost =
        sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto relative, std::size_t) {
          const Channels value = moments.quotient(value_of(f, x), psi);
          fit.add(relative, value);
          for (std::size_t c = 0; c < channels; ++c) sum[c] += value[c];
          for (std::size_t k = 0; k < n; ++k) row[channels + k] += static_cast<double>(relative[k]);
        });
    for (std::size_t c = 0; c < channels; ++c) {
      row[c] = static_cast<double>(sum[c]);
      sum[c] /= static_cast<typename EstimateAccumulator<F>::A>(total);
    }
    for (std::size_t i = 0; i < width; ++i) {
      row[i] = row[i] / static_cast<double>(total) - mean[i];  // from the mean so far [Welford]
      mean[i] += row[i] / static_cast<double>(round + 1);
    }
    const double factor = static_cast<double>(round) / static_cast<double>(round + 1);
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < width; ++j) products[i * width + j] += factor * row[i] * row[j];
    moments.add_estimate(sum, total, cost);
  }

  const std::vector<double> coefficients = fit.coefficients();
  const auto mean_of = [&](std::size_t c) {
    double result = mean[c];
    for (std::size_t k = 0; k < n; ++k) result += coefficients[c * n + k] * (1.0 - mean[channels + k]);
    return result;
  };
  const auto variance_of = [&](std::size_t c) {
    const auto direction = [&](std::size_t i) {
      return i < channels ? (i == c ? 1.0 : 0.0) : -coefficients[c * n + i - channels];
    };
    double result = 0.0;
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < width; ++j) result += direction(i) * products[i * width + j] * direction(j);
    const double samples = static_cast<double>(fit.samples());
    const double freedom = samples > static_cast<double>(n) ? samples / (samples - static_cast<double>(n)) : 1.0;
    return std::max(0.0, result) / static_cast<double>(rounds - 1) * freedom;
  };
  return moments.result(mean_of, variance_of);
}

}  // namespace gmis
