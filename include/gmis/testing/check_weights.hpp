#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "gmis/mis/arguments.hpp"
#include "gmis/mis/counted_round.hpp"
#include "gmis/mis/proposal_set.hpp"

namespace gmis {

/// Checks the two conditions under which MIS weights are unbiased: they sum to one wherever a
/// technique makes samples, and vanish where their own technique makes none [Veach 1997, section
/// 9.2]. Any weights can be added, point by point, or path by path with one weight for each
/// technique.
class WeightCheck {
 public:
  /// One point. `densities[k]`: expected sample density n_k q_k of technique k (any common factor),
  /// `weights[k]` the weight of its samples there. Throws std::invalid_argument when the sizes
  /// differ.
  template <class D, class W>
  void add(std::span<const D> densities, std::span<const W> weights) {
    require_argument(densities.size() == weights.size(), "give one weight for each density");
    ++points_;
    double sum = 0.0, without = 0.0;
    bool any = false, finite = true;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const double weight = static_cast<double>(weights[k]), density = static_cast<double>(densities[k]);
      finite = finite && density >= 0.0 && std::isfinite(density);
      if (density > 0.0) {
        any = true;
        sum += weight;
        finite = finite && std::isfinite(weight);
      } else if (!(std::abs(weight) <= without)) {
        without = std::isfinite(weight) ? std::abs(weight) : 1.0;
      }
    }
    if (!finite) {
      ++not_finite_;
      return;
    }
    if (!any) {
      ++unreached_;
      return;
    }
    without_density_ = std::max(without_density_, without);
    if (std::abs(sum - 1.0) > sum_error_) {
      sum_error_ = std::abs(sum - 1.0);
      worst_ = points_ - 1;
    }
  }
  /// Adds one point, from vectors.
  template <class D, class W>
  void add(const std::vector<D>& densities, const std::vector<W>& weights) {
    add(std::span<const D>(densities), std::span<const W>(weights));
  }

  /// Points that were added.
  [[nodiscard]] std::size_t points() const noexcept { return points_; }
  /// Points where no technique makes samples: nothing is asked of their weights.
  [[nodiscard]] std::size_t unreached() const noexcept { return unreached_; }
  /// Points with a weight or a density that is NaN or infinite, or with a negative density. Nothing
  /// else is asked of them.
  [[nodiscard]] std::size_t not_finite() const noexcept { return not_finite_; }
  /// Largest |Σ w − 1| over the points.
  [[nodiscard]] double sum_error() const noexcept { return sum_error_; }
  /// Number of the point, in the order of adding, where the sum is off the most.
  [[nodiscard]] std::size_t worst() const noexcept { return worst_; }
  /// Largest |w_k| where n_k q_k = 0.
  [[nodiscard]] double without_density() const noexcept { return without_density_; }

  /// True when all sums are one and no technique has a weight where it makes no samples, both
  /// within `tolerance`. False also when no point was reached by any technique.
  [[nodiscard]] bool passes(double tolerance = 1e-9) const noexcept {
    return points_ > unreached_ && not_finite_ == 0 && sum_error_ <= tolerance && without_density_ <= tolerance;
  }
  /// The figures in one line.
  [[nodiscard]] std::string text() const {
    char buffer[256];
    std::snprintf(
        buffer, sizeof(buffer),
        "%zu points, %zu reached by no technique, %zu not finite; sums off one by up to %.3g (point %zu), weights "
        "without density up to %.3g\n",
        points_, unreached_, not_finite_, sum_error_, worst_, without_density_);
    return buffer;
  }

 private:
  std::size_t points_ = 0, unreached_ = 0, not_finite_ = 0, worst_ = 0;
  double sum_error_ = 0.0, without_density_ = 0.0;
};

/// Checks weights at given points. `weights(x, out)` writes one weight for each proposal to a
/// `std::span<double>`; `counts` are the samples of each proposal. `points` is a range of samples.
/// Name `Source`, a source that the proposals take, where they do not take `Philox`.
template <class Source = Philox, class Weights, class P, class Points>
[[nodiscard]] WeightCheck check_weights_at(const Points& points, Weights&& weights, const P& proposals,
                                           CountsByProposal counts) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  const std::size_t n = set.size();
  (void)checked_total(counts, n);
  std::vector<double> densities(n), out(n);
  std::vector<typename Set::Density> workspace(n);
  WeightCheck check;
  for (const auto& point : points) {
    const typename Set::Value x = static_cast<typename Set::Value>(point);
    DensitiesAt<Set> at(set, x, workspace.data());
    at.expect_all();
    constexpr double minus_infinity = -std::numeric_limits<double>::infinity();
    double largest = minus_infinity;
    for (std::size_t k = 0; k < n; ++k) {
      densities[k] = static_cast<double>(at[k]);
      largest = std::max(largest, densities[k]);
    }
    for (std::size_t k = 0; k < n; ++k) {
      // An infinite density becomes NaN, which `add` does not take for a density of 0.
      if constexpr (is_log_set<Set>)
        densities[k] = densities[k] == minus_infinity ? 0.0 : std::exp(densities[k] - largest);
      densities[k] *= counts[k];
    }
    std::fill(out.begin(), out.end(), std::numeric_limits<double>::quiet_NaN());
    weights(x, std::span<double>(out));
    check.add(densities, out);
  }
  return check;
}

/// `check_weights_at` at points that are drawn: `each` samples of every proposal, those without
/// samples included.
template <class Weights, class P, UniformSource Source>
[[nodiscard]] WeightCheck check_weights(Weights&& weights, const P& proposals, CountsByProposal counts,
                                        std::size_t each, Source& source) {
  const auto& set = as_proposal_set<Source>(proposals);
  using Set = std::remove_cvref_t<decltype(set)>;
  std::vector<typename Set::Value> points;
  for (std::size_t k = 0; k < set.size(); ++k)
    for (std::size_t i = 0; i < each; ++i) {
      auto x = set.sample(k, source);
      if constexpr (SampleResult<decltype(x)>::can_fail) {
        if (x) points.push_back(*x);
      } else {
        points.push_back(std::move(x));
      }
    }
  return check_weights_at<Source>(points, weights, proposals, counts);
}

}  // namespace gmis
