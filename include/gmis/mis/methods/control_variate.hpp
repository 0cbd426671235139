#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/methods/semidefinite_solve.hpp"

/// \file
/// The densities of the proposals as control variates of a mixture [Owen, Zhou: Safe and effective
/// importance sampling, 2000]: Σ β_k + (1/n) Σ (f − Σ β_k q_k)/ψ estimates ∫ f for every β, since ∫
/// q_k = 1. Costs no evaluation more than N3.

namespace gmis {

/// The least-squares fit of f/ψ by q_k/ψ over samples of ψ, which minimises ∫ (f − Σ β_k q_k)²/ψ.
/// No other coefficients give N3 with counts a lower variance [Kondapaneni et al. 2019].
template <Summable F>
class ControlFit {
 public:
  using Channels = typename EstimateAccumulator<F>::Channels;
  static constexpr std::size_t channel_count = EstimateAccumulator<F>::channel_count;

  /// A fit for this number of proposals.
  explicit ControlFit(std::size_t proposal_count)
      : n_(proposal_count), matrix_(n_ * n_), right_side_(channel_count * n_) {}

  /// One sample: q_k/ψ, and f/ψ in every channel.
  template <class T>
  void add(std::span<const T> relative, const Channels& value) noexcept {
    ++samples_;
    for (std::size_t i = 0; i < n_; ++i) {
      const double r = static_cast<double>(relative[i]);
      for (std::size_t j = 0; j <= i; ++j) matrix_[i * n_ + j] += r * static_cast<double>(relative[j]);
      for (std::size_t c = 0; c < channel_count; ++c) right_side_[c * n_ + i] += r * static_cast<double>(value[c]);
    }
  }
  void merge(const ControlFit& other) noexcept {
    samples_ += other.samples_;
    for (std::size_t i = 0; i < matrix_.size(); ++i) matrix_[i] += other.matrix_[i];
    for (std::size_t i = 0; i < right_side_.size(); ++i) right_side_[i] += other.right_side_[i];
  }
  /// Samples that were added.
  [[nodiscard]] std::uint64_t samples() const noexcept { return samples_; }

  /// β, channel by channel: coefficient k of channel c at [c N + k].
  [[nodiscard]] std::vector<double> coefficients() const {
    std::vector<double> full = matrix_, result;
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t j = i + 1; j < n_; ++j) full[i * n_ + j] = matrix_[j * n_ + i];
    for (std::size_t c = 0; c < channel_count; ++c) {
      const std::vector<double> channel =
          solve_semidefinite(full, std::span<const double>(right_side_).subspan(c * n_, n_));
      result.insert(result.end(), channel.begin(), channel.end());
    }
    return result;
  }

 private:
  std::size_t n_;
  std::uint64_t samples_ = 0;
  std::vector<double> matrix_;  // lower triangle
  std::vector<double> right_side_;
};

/// True for a set whose `sample` may return nothing. Its densities integrate to less than one, and
/// are no control variates.
template <class Set, class Source = Philox>
inline constexpr bool set_can_fail = SampleResult<
    std::remove_cvref_t<decltype(std::declval<const Set&>().sample(std::size_t{}, std::declval<Source&>()))>>::can_fail;

namespace detail {
inline void require_coefficients(std::span<const double> coefficients) {
  for (const double coefficient : coefficients)
    require_argument(std::isfinite(coefficient), "the coefficient of a control variate is not a finite number");
}
}  // namespace detail

/// Estimates ∫ f with `rounds` ≥ 1 rounds of N3 with counts and control variates of given
/// `coefficients` (N for each channel, channel by channel), from a `ControlFit` of an earlier run
/// or from `control_coefficients`. Unbiased for all coefficients when ψ > 0 wherever f or a
/// proposal with β_k ≠ 0 is not zero. Proposals must not fail. Throws std::invalid_argument for a
/// coefficient that is not finite.
template <class Integrand, class P, class Source>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_controlled(Integrand&& f, const P& proposals, CountsByProposal counts,
                                           std::span<const double> coefficients, std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  static_assert(!set_can_fail<Set, Source>, "control variates need proposals that always make a sample");
  const std::size_t n = set.size();
  const std::size_t total = checked_total(counts, n);
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  using Channels = typename EstimateAccumulator<F>::Channels;
  using A = typename EstimateAccumulator<F>::A;
  require_argument(coefficients.size() == n * moments.channel_count,
                   "give one coefficient for each proposal and channel");
  detail::require_coefficients(coefficients);

  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    Channels sum{};
    const RoundCounts cost =
        sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto relative, std::size_t) {
          const Channels value = moments.quotient(value_of(f, x), psi);
          for (std::size_t c = 0; c < sum.size(); ++c) {
            A control(0);
            for (std::size_t k = 0; k < n; ++k)
              control += static_cast<A>(coefficients[c * n + k]) * static_cast<A>(relative[k]);
            sum[c] += value[c] - control;
          }
        });
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c] /= static_cast<A>(total);
      for (std::size_t k = 0; k < n; ++k) sum[c] += static_cast<A>(coefficients[c * n + k]);
    }
    moments.add_estimate(sum, total, cost);
  }
  return moments.result();
}

/// The best coefficients for a tabulated problem (a quadrature rule, or a pilot): Σ_k β_k ∫ q_i
/// q_k/ψ = ∫ f q_i/ψ.
[[nodiscard]] inline std::vector<double> control_coefficients(CountsByProposal counts,
                                                              const TabulatedProblem& problem) {
  const std::size_t n = problem.proposal_count();
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  std::vector<double> matrix(n * n), right_side(n);
  for (std::size_t node = 0; node < psi.size(); ++node) {
    if (!(psi[node] > 0.0)) continue;
    for (std::size_t i = 0; i < n; ++i) {
      const double q = problem.weights()[node] * (problem.densities(i)[node] / psi[node]);
      right_side[i] += q * problem.values()[node];
      for (std::size_t j = 0; j < n; ++j) matrix[i * n + j] += q * problem.densities(j)[node];
    }
  }
  return solve_semidefinite(matrix, right_side);
}

/// Mean and variance of one round of `estimate_controlled`: those of N3 with counts for f − Σ β_k
/// q_k, the mean moved by Σ β_k.
[[nodiscard]] inline ExactMoments exact_moments_controlled(CountsByProposal counts,
                                                           std::span<const double> coefficients,
                                                           const TabulatedProblem& problem) {
  const std::size_t n = problem.proposal_count();
  const double total = static_cast<double>(checked_total(counts, n));
  require_argument(coefficients.size() == n, "give one coefficient for each proposal");
  detail::require_coefficients(coefficients);
  const std::vector<double> psi = mixture_of(fractions_of(counts), problem);
  const auto residual = [&](std::size_t i) {
    double value = problem.values()[i];
    for (std::size_t k = 0; k < n; ++k) value -= coefficients[k] * problem.densities(k)[i];
    return value;
  };
  double mean = 0.0;
  for (const double coefficient : coefficients) mean += coefficient;
  for (std::size_t i = 0; i < psi.size(); ++i)
    if (psi[i] > 0.0) mean += problem.weights()[i] * residual(i);
  const ExactMoments moments = moments_of_contributions(
      problem, counts, [&](std::size_t, std::size_t i) { return residual(i) / psi[i] / total; });
  return {mean, moments.variance};
}

}  // namespace gmis
