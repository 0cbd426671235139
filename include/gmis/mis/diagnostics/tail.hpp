#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/mis/estimate.hpp"

/// \file
/// Whether a standard error can be trusted, judged from the samples of the estimate alone: how much
/// of the estimate comes from a few of them. Opt-in, with `estimate_with_tail`; `estimate` pays
/// nothing for it.

namespace gmis {

/// The contributions |f/φ| of an estimate, by size. Keeps the 1,024 largest.
class ContributionTail {
 public:
  /// Adds |contribution| of one sample; samples that contribute zero count, too.
  void add(double contribution) {
    const double size = std::abs(contribution);
    ++samples_;
    sum_ += size;
    squares_ += size * size;
    if (largest_.size() < kept) {
      largest_.push_back(size);
      if (largest_.size() == kept) std::make_heap(largest_.begin(), largest_.end(), std::greater<>());
    } else if (size > largest_.front()) {
      std::pop_heap(largest_.begin(), largest_.end(), std::greater<>());
      largest_.back() = size;
      std::push_heap(largest_.begin(), largest_.end(), std::greater<>());
    }
  }

  /// Contributions that were added.
  [[nodiscard]] std::uint64_t samples() const noexcept { return samples_; }
  /// (Σ |c|)²/Σ c²: the number of equal contributions with the same Σ |c| and Σ c².
  /// 0 without contributions.
  [[nodiscard]] double effective_sample_size() const noexcept { return squares_ > 0.0 ? sum_ * sum_ / squares_ : 0.0; }
  /// Largest |c| over Σ |c|.
  [[nodiscard]] double share_of_largest() const {
    return sum_ > 0.0 ? *std::max_element(largest_.begin(), largest_.end()) / sum_ : 0.0;
  }

  /// Shape k̂ of a generalised Pareto distribution fitted to the M largest contributions, M =
  /// min(S/5, 3 √S, 1023) of S samples [Vehtari, Simpson, Gelman, Yao, Gabry: Pareto smoothed
  /// importance sampling, 2024; the fit: Zhang, Stephens 2009], shrunk towards 1/2 with the weight
  /// of ten samples. Moments of order 1/k and above are infinite: above 1/2 the variance, above 1
  /// the mean. −infinity where fewer than 5 of the M are larger than the next one, NaN for fewer
  /// than 25 samples.
  [[nodiscard]] double pareto_shape() const {
    if (samples_ < 25) return std::numeric_limits<double>::quiet_NaN();
    const std::size_t count = tail_count();
    std::vector<double> tail = largest_;
    std::sort(tail.begin(), tail.end(), std::greater<>());
    const double threshold = tail[count];
    tail.resize(count);
    // Contributions at the threshold are none above it: many equal ones, or equal but for rounding,
    // would look like the body of a heavy tail.
    std::erase_if(tail, [threshold](double x) { return x - threshold <= 1e-12 * threshold; });
    if (tail.size() < fewest_above) return -std::numeric_limits<double>::infinity();
    std::reverse(tail.begin(), tail.end());
    for (double& x : tail) x -= threshold;
    const double n = static_cast<double>(tail.size());
    const double scale = tail[static_cast<std::size_t>(std::lround(n / 4.0)) - 1];  // the first quartile
    const auto shape_for = [&](double theta) {
      double sum = 0.0;
      for (const double x : tail) sum += std::log1p(-theta * x);
      return sum / n;
    };
    const std::size_t grid = 30 + static_cast<std::size_t>(std::sqrt(n));
    std::vector<double> theta(grid), likelihood(grid);
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < grid; ++j) {
      const double g = static_cast<double>(grid), place = static_cast<double>(j) + 0.5;
      theta[j] = 1.0 / tail.back() + (1.0 - std::sqrt(g / place)) / (3.0 * scale);
      const double shape = shape_for(theta[j]);
      likelihood[j] = n * (std::log(-theta[j] / shape) - shape - 1.0);
      if (likelihood[j] > best) best = likelihood[j];  // NaN at a θ of 0 is left out
    }
    double weights = 0.0, weighted = 0.0;
    for (std::size_t j = 0; j < grid; ++j) {
      const double weight = std::exp(likelihood[j] - best);
      if (!(weight > 0.0)) continue;
      weights += weight;
      weighted += weight * theta[j];
    }
    const double shape = shape_for(weighted / weights);
    return (n * shape + 5.0) / (n + 10.0);
  }

  /// False when the standard error is not to be trusted: k̂ above min(1/2 + 4/√M, 0.7), that is
  /// above 1/2, where the variance is infinite, by more than the uncertainty of k̂; or one sample
  /// that is more than a tenth of the sum of at least 1,000. k̂ is disregarded where the largest
  /// contribution is below twice the (M + 1)-th: the largest of a heavy tail is some M^k̂ times
  /// that.
  [[nodiscard]] bool is_reliable() const {
    if (samples_ >= 1000 && share_of_largest() > 0.1) return false;
    const double limit = std::min(0.5 + 4.0 / std::sqrt(std::max(1.0, static_cast<double>(tail_count()))), 0.7);
    return !(pareto_shape() > limit && largest_is_far());
  }

 private:
  static constexpr std::size_t kept = 1024, fewest_above = 5;
  /// M.
  [[nodiscard]] std::size_t tail_count() const noexcept {
    const double all = static_cast<double>(samples_);
    return std::min({static_cast<std::size_t>(0.2 * all), static_cast<std::size_t>(3.0 * std::sqrt(all)), kept - 1});
  }

  /// Whether the largest contribution is at least twice the (M + 1)-th.
  [[nodiscard]] bool largest_is_far() const {
    std::vector<double> sorted = largest_;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    return sorted[0] >= 2.0 * sorted[tail_count()];
  }

  std::uint64_t samples_ = 0;
  double sum_ = 0.0, squares_ = 0.0;
  std::vector<double> largest_;  // a heap with the least in front once it is full
};

/// An estimate and the tail of its contributions (their first channel).
template <class V>
struct EstimateWithTail {
  Estimate<V> estimate;   ///< as `estimate` returns it
  ContributionTail tail;  ///< of all samples that could be used
};

/// The estimate that `estimate` returns, and the tail of its contributions f/φ. Both functions draw
/// the numbers of one stream, so the estimates are equal.
template <Scheme scheme, class Integrand, class P, class Source, class AllocationType = EqualAllocation>
requires(detail::explain_arguments<Integrand, P, Source>())
    [[nodiscard]] auto estimate_with_tail(Integrand&& f, const P& proposals, std::uint64_t rounds, Source&& source,
                                          const AllocationType& allocation = {}) {
  using S = std::remove_reference_t<Source>;
  constexpr SelectionAndWeighting pair = cheapest_pair(scheme);
  const auto& set = as_proposal_set<S>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  using F = SummandOf<Integrand, typename Set::Value>;
  require_rounds(rounds);
  allocation.require_fits(set.size(), pair.selection);
  ContributionTail tail;
  std::optional<F> value;  // of the last sample
  const auto f_kept = [&](const typename Set::Value& x) {
    value = value_of(f, x);
    return *value;
  };
  EstimateAccumulator<F> accumulator;
  Workspace<typename Set::Density, dynamic_capacity> workspace;
  const std::size_t sample_count = allocation.sample_count(set.size());
  workspace.prepare(set.size(), sample_count);
  accumulator.add_rounds(f_kept, sample_count, rounds, [&](RoundCounts& counts, auto&& visit) {
    sample_checked_round<pair.selection, pair.weighting>(
        set, allocation, source, workspace, counts, [&](const auto& x, auto denominator, std::size_t index) {
          visit(x, denominator, index);
          if (!is_finite(*value)) return;
          const double contribution = ratio<double>(SpectrumTraits<F>::channel(*value, 0), denominator);
          if (std::isfinite(contribution)) tail.add(contribution);
        });
  });
  using V = typename EstimateAccumulator<F>::Mean;
  return EstimateWithTail<V>{accumulator.result(), std::move(tail)};
}

}  // namespace gmis
