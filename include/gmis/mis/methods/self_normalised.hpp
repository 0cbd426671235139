#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "gmis/mis/contribution.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/estimate.hpp"

namespace gmis {

/// Means under a density π known up to a factor, Σ w h / Σ w, and what is known of their error.
template <std::size_t M>
struct SelfNormalisedEstimate {
  std::array<double, M> mean{};  ///< of h_1 … h_M under π. Biased by a term of the order 1/rounds
  /// Covariance of `mean`, from the spread of w (h − mean) between rounds (delta method); nothing
  /// for a single round. Its error is of the order 1/rounds, and it knows nothing of a mode of π
  /// that no sample has met. No diagonal element is negative.
  std::optional<std::array<std::array<double, M>, M>> covariance{};
  double normaliser = 0.0;                   ///< an unbiased estimate of the integral of the unnormalised π
  std::optional<double> normaliser_error{};  ///< its standard error
  double effective_sample_size = 0.0;     ///< (Σ w)²/Σ w² [Kong 1992]: 0 … samples. Small: few samples carry all
  std::uint64_t rounds = 0;               ///< that were drawn
  std::uint64_t samples = 0;              ///< in all rounds
  std::uint64_t density_evaluations = 0;  ///< of proposals
  Rejected rejected{};                    ///< samples that count as zero, by cause

  /// Standard error of mean i, by the delta method; nothing for a single round.
  [[nodiscard]] std::optional<double> standard_error(std::size_t i) const noexcept {
    return covariance ? std::optional(std::sqrt((*covariance)[i][i])) : std::nullopt;
  }
};

/// The sums of self-normalised estimates: one `add` a sample, one `close_round` a round. Rounds
/// must be independent.
template <std::size_t M>
class SelfNormalisedSums {
 public:
  /// A sample with the weight w = π/(n ψ) and the values h(x).
  void add(double weight, const std::array<double, M>& values) noexcept {
    weight_squares_ += weight * weight;
    weights_ += weight;
    round_[M] += weight;
    for (std::size_t i = 0; i < M; ++i) round_[i] += weight * values[i];
  }
  /// Ends a round: its sums count as one observation.
  void close_round() noexcept {
    ++rounds_;
    const double factor = static_cast<double>(rounds_ - 1) / static_cast<double>(rounds_);
    for (std::size_t i = 0; i <= M; ++i) round_[i] -= mean_[i];
    for (std::size_t i = 0; i <= M; ++i)
      for (std::size_t j = 0; j <= M; ++j) products_[i][j] += factor * round_[i] * round_[j];  // [Welford]
    for (std::size_t i = 0; i <= M; ++i) mean_[i] += round_[i] / static_cast<double>(rounds_);
    round_ = {};
  }
  /// The ratios from the rounds so far.
  [[nodiscard]] SelfNormalisedEstimate<M> result() const noexcept {
    SelfNormalisedEstimate<M> estimate;
    const double normaliser = mean_[M];
    estimate.rounds = rounds_;
    estimate.normaliser = normaliser;
    estimate.effective_sample_size = weight_squares_ > 0.0 ? weights_ * weights_ / weight_squares_ : 0.0;
    for (std::size_t i = 0; i < M; ++i) estimate.mean[i] = normaliser > 0.0 ? mean_[i] / normaliser : 0.0;
    if (rounds_ < 2 || !(normaliser > 0.0)) return estimate;
    const double scale = 1.0 / (static_cast<double>(rounds_) * static_cast<double>(rounds_ - 1));
    estimate.normaliser_error = std::sqrt(products_[M][M] * scale);
    estimate.covariance.emplace();
    // Cov(Σ w (h_i − μ_i), Σ w (h_j − μ_j)) / Z², from the products of sums.
    for (std::size_t i = 0; i < M; ++i)
      for (std::size_t j = 0; j < M; ++j)
        (*estimate.covariance)[i][j] =
            scale / (normaliser * normaliser) *
            (products_[i][j] - estimate.mean[i] * products_[M][j] - estimate.mean[j] * products_[i][M] +
             estimate.mean[i] * estimate.mean[j] * products_[M][M]);
    // Rounding can make the variance of an almost constant h negative.
    for (std::size_t i = 0; i < M; ++i) (*estimate.covariance)[i][i] = std::max((*estimate.covariance)[i][i], 0.0);
    return estimate;
  }

 private:
  std::array<double, M + 1> round_{}, mean_{};  // of w h_1 … w h_M, w
  std::array<std::array<double, M + 1>, M + 1> products_{};
  double weights_ = 0.0, weight_squares_ = 0.0;
  std::uint64_t rounds_ = 0;
};

/// Estimates the means of h(x), a `std::array<double, M>`, under the density that `target` is
/// proportional to, with `rounds` rounds of N3 with counts. `target` returns a number ≥ 0 or a
/// `LogValue`. Consistent, not unbiased, where ψ > 0 wherever the target is. Samples with a target
/// or value that is not finite are counted and left out.
template <class Target, class Values, class P, class Source>
requires(detail::explain_arguments<Target, P, Source>())
    [[nodiscard]] auto estimate_self_normalised(Target&& target, Values&& h, const P& proposals,
                                                CountsByProposal counts, std::uint64_t rounds, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using H = std::remove_cvref_t<decltype(h(std::declval<const typename Set::Value&>()))>;
  constexpr std::size_t m = std::tuple_size_v<H>;
  const std::size_t total = checked_total(counts, set.size());
  require_rounds(rounds);
  SelfNormalisedSums<m> sums;
  Rejected rejected;
  std::uint64_t evaluations = 0;
  CountedWorkspace<Set> workspace;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const RoundCounts cost =
        sample_counted_round(set, counts, source, workspace, [&](const auto& x, auto psi, auto, std::size_t) {
          const auto value = target(x);
          const double weight = is_finite(value) ? ratio<double>(value, psi) / static_cast<double>(total) : -1.0;
          const H values = h(x);
          double difference = 0.0;
          for (std::size_t i = 0; i < m; ++i) difference += values[i] - values[i];
          if (!(weight >= 0.0 && std::isfinite(weight)) || difference != 0.0) {
            ++rejected.non_finite_integrand;
            return;
          }
          sums.add(weight, values);
        });
    evaluations += cost.density_evaluations;
    rejected.zero_density += cost.zero_density;
    rejected.non_finite_density += cost.non_finite_density;
    sums.close_round();
  }
  SelfNormalisedEstimate<m> estimate = sums.result();
  estimate.samples = rounds * total;
  estimate.density_evaluations = evaluations;
  estimate.rejected = rejected;
  return estimate;
}

}  // namespace gmis
