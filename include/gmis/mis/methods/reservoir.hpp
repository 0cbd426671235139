#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "gmis/core/random.hpp"

namespace gmis {

/// One sample chosen from a stream, with probability in proportion to its weight [Chao 1982]: what
/// resampled importance sampling keeps. Weights are finite and not negative (`add` leaves others
/// out and counts them).
template <class X>
class Reservoir {
 public:
  /// Offers `x` with weight w; the sample kept so far is replaced with probability w over the sum
  /// of all weights. Returns whether it was.
  template <UniformSource Source>
  bool add(const X& x, double weight, Source& source) {
    if (!(weight >= 0.0 && std::isfinite(weight))) [[unlikely]] {
      ++rejected_;
      return false;
    }
    if (weight == 0.0) return false;
    weight_sum_ += weight;
    if (sample_ && uniform<double>(source) * weight_sum_ >= weight) return false;
    sample_ = x;
    return true;
  }
  /// Ends the resampling for a target p̂: the unbiased contribution weight becomes W = Σ w / p̂(y),
  /// E[W | y] = 1/p(y).
  void finish(double target_at_sample, double sample_count) noexcept {
    contribution_weight_ = sample_ && target_at_sample > 0.0 ? weight_sum_ / target_at_sample : 0.0;
    sample_count_ = sample_count;
  }

  /// The sample y; nothing when no weight was positive. f(y) W estimates ∫ f, as zero without a
  /// sample.
  [[nodiscard]] const std::optional<X>& sample() const noexcept { return sample_; }
  /// W, an unbiased estimate of 1/p(y). 0 without a sample.
  [[nodiscard]] double contribution_weight() const noexcept { return contribution_weight_; }
  /// M, the number of candidates that the sample stands for.
  [[nodiscard]] double sample_count() const noexcept { return sample_count_; }
  /// Offers whose weight was negative or not finite.
  [[nodiscard]] std::uint64_t rejected() const noexcept { return rejected_; }

 private:
  std::optional<X> sample_;
  double weight_sum_ = 0.0;
  double contribution_weight_ = 0.0;
  double sample_count_ = 0.0;
  std::uint64_t rejected_ = 0;
};

/// Joins reservoirs to one with the target `target`: generalised resampled importance sampling
/// [Lin, Kettunen, Bitterli, Pantaleoni, Yuksel, Wyman: Generalized resampled importance sampling,
/// 2022]. Reservoir k was made for the target `target_of(k, x)`; its sample gets the weight
/// m_k(y_k) p̂(y_k) W_k with the generalised balance heuristic m_k(x) = M_k p̂_k(x)/Σ M_j p̂_j(x),
/// in which targets stand for the densities that nobody knows. K² targets.
///
/// The result is unbiased for every f that is zero where p̂ is zero or all p̂_k are. The reservoirs
/// must be independent of each other, or their samples at least not chosen with a view to each
/// other.
template <class X, class TargetOf, class Target, UniformSource Source>
[[nodiscard]] Reservoir<X> join_reservoirs(std::span<const Reservoir<X>> reservoirs, TargetOf&& target_of,
                                           Target&& target, Source& source) {
  Reservoir<X> joined;
  double count = 0.0, chosen_target = 0.0;
  for (std::size_t k = 0; k < reservoirs.size(); ++k) {
    count += reservoirs[k].sample_count();
    if (!reservoirs[k].sample() || reservoirs[k].contribution_weight() == 0.0) continue;
    const X& x = *reservoirs[k].sample();
    double sum = 0.0, own = 0.0;
    for (std::size_t j = 0; j < reservoirs.size(); ++j) {
      const double part = reservoirs[j].sample_count() * static_cast<double>(target_of(j, x));
      sum += part;
      if (j == k) own = part;
    }
    if (!(own > 0.0)) continue;
    const double value = static_cast<double>(target(x));
    if (joined.add(x, own / sum * value * reservoirs[k].contribution_weight(), source)) chosen_target = value;
  }
  joined.finish(chosen_target, count);
  return joined;
}

}  // namespace gmis
