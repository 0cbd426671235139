#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "gmis/mis/estimate.hpp"

namespace gmis {

/// Mean, variance and counts over rounds, for estimators whose rounds are more than a mean of f /
/// φ. The caller adds one value of each channel a round; `EstimateAccumulator` is the one for plain
/// rounds.
template <Summable F>
class RoundMoments {
  using Traits = SpectrumTraits<F>;

 public:
  using A = AccumulatorOf<typename Traits::Scalar>;
  static constexpr std::size_t channel_count = static_cast<std::size_t>(Traits::channel_count);
  using Channels = std::array<A, channel_count>;
  using Mean = typename EstimateAccumulator<F>::Mean;

  /// f / denominator in every channel. All zeros, and the fault counted, when f or the quotient is
  /// not finite.
  template <class D>
  [[nodiscard]] Channels quotient(const F& value, D denominator) noexcept {
    ++integrand_evaluations_;
    Channels result{};
    if (!is_finite(value)) [[unlikely]] {
      ++rejected_.non_finite_integrand;
      return result;
    }
    A difference(0);  // x − x is zero for finite x alone, so one sum tests all channels
    for (std::size_t c = 0; c < channel_count; ++c) {
      result[c] = ratio<A>(Traits::channel(value, static_cast<int>(c)), denominator);
      difference += result[c] - result[c];
    }
    if (difference != A(0)) [[unlikely]] {
      ++rejected_.non_finite_contribution;
      return {};
    }
    return result;
  }

  /// Adds one round: its estimate in every channel, and what it cost.
  void add_round(const Channels& estimate, std::size_t sample_count, const RoundCounts& counts) noexcept {
    for (std::size_t c = 0; c < channel_count; ++c) moments_[c].add(estimate[c]);
    add_cost(sample_count, counts);
  }
  /// Adds what a round cost that is not part of the estimate (a warm-up).
  void add_cost(std::size_t sample_count, const RoundCounts& counts) noexcept {
    samples_ += sample_count;
    density_evaluations_ += counts.density_evaluations;
    failed_samples_ += counts.failed_samples;
    rejected_.zero_density += counts.zero_density;
    rejected_.non_finite_density += counts.non_finite_density;
  }

  /// The mean over rounds. `mean_of(c)` and `variance_of(c)` may be given where the estimate is not
  /// the mean of the rounds.
  [[nodiscard]] Estimate<Mean> result() const {
    return result([&](std::size_t c) { return moments_[c].mean(); },
                  [&](std::size_t c) { return moments_[c].variance(); });
  }
  template <class MeanOf, class VarianceOf>
  [[nodiscard]] Estimate<Mean> result(MeanOf mean_of, VarianceOf variance_of) const {
    Estimate<Mean> estimate;
    estimate.rounds = moments_[0].count();
    estimate.mean = gather(mean_of);
    if (estimate.rounds > 1) {
      estimate.variance = gather(variance_of);
      estimate.standard_error =
          gather([&](std::size_t c) { return std::sqrt(variance_of(c) / static_cast<A>(estimate.rounds)); });
    }
    estimate.samples = samples_;
    estimate.density_evaluations = density_evaluations_;
    estimate.integrand_evaluations = integrand_evaluations_;
    estimate.failed_samples = failed_samples_;
    estimate.rejected = rejected_;
    return estimate;
  }

 private:
  template <class Get>
  [[nodiscard]] static Mean gather(Get get) {
    if constexpr (channel_count == 1) {
      return static_cast<Mean>(get(0));
    } else {
      using Index = std::conditional_t < requires {
        Mean{}.length();
      }
      , int, std::size_t > ;
      Mean mean;
      for (std::size_t c = 0; c < channel_count; ++c) mean[static_cast<Index>(c)] = static_cast<A>(get(c));
      return mean;
    }
  }

  std::array<Moments<A>, channel_count> moments_;
  std::uint64_t samples_ = 0;
  std::uint64_t density_evaluations_ = 0;
  std::uint64_t integrand_evaluations_ = 0;
  std::uint64_t failed_samples_ = 0;
  Rejected rejected_;
};

}  // namespace gmis
