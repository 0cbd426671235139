#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/moments.hpp"

namespace gmis {

/// A variance averaged over random draws of the indices, with its 99 % confidence interval value ±
/// half_width (normal approximation).
struct AveragedVariance {
  double value;       ///< the mean over the draws
  double half_width;  ///< of its interval
};

/// The variance of one round under R2 or N2 for any N: quadrature given the indices, averaged over
/// `draws` ≥ 2 random draws of them. Costs N (R2: 2N) passes over the nodes a draw. Throws
/// std::invalid_argument for the other schemes, whose `exact_variance` is cheap for every N, for
/// fewer than two draws, and when the proposals lack full support. Infinite, and so is its
/// interval, where a variance given the indices is.
template <UniformSource Source>
[[nodiscard]] AveragedVariance averaged_variance(Scheme scheme, const TabulatedProblem& problem, std::uint64_t draws,
                                                 Source& source) {
  require_argument(scheme == Scheme::R2 || scheme == Scheme::N2, "only R2 and N2 need averaging: use exact_variance");
  require_argument(draws >= 2, "averaged_variance needs at least two draws");
  require_argument(problem.has_full_support(), "averaged_variance needs full support");
  const std::size_t n = problem.proposal_count();
  const double count = static_cast<double>(n);
  const double integral = problem.integral();
  std::vector<double> sum(problem.node_count()), divided(problem.node_count()), multiplicity(n);
  std::vector<std::size_t> order(n);
  Moments<double> moments;

  for (std::uint64_t draw = 0; draw < draws; ++draw) {
    std::fill(sum.begin(), sum.end(), 0.0);
    if (scheme == Scheme::R2) {
      std::fill(multiplicity.begin(), multiplicity.end(), 0.0);
      for (std::size_t i = 0; i < n; ++i) multiplicity[uniform_index(source, static_cast<std::uint32_t>(n))] += 1.0;
      for (std::size_t i = 0; i < n; ++i)
        if (multiplicity[i] > 0.0) problem.add_density(i, multiplicity[i], sum.data(), sum.data());
      problem.divide(count, sum.data(), divided.data());
      moments.add(
          detail::conditional_variance(problem, divided.data(), count, [&](auto i) { return multiplicity[i]; }));
    } else {
      // One order of drawing holds one subset of every size: its first 1, 2, … N from the far end.
      double second_moment = 0.0;
      for (std::size_t i = 0; i < n; ++i) order[i] = i;
      for (std::size_t size = 1; size <= n; ++size) {
        const std::size_t left = n - size + 1;
        std::swap(order[left - 1], order[uniform_index(source, static_cast<std::uint32_t>(left))]);
        problem.add_density(order[left - 1], 1.0, sum.data(), sum.data());
        problem.divide(static_cast<double>(size), sum.data(), divided.data());
        second_moment += problem.squared_over(divided.data()) / count;
      }
      moments.add(detail::variance_from(second_moment / count, integral * integral / count));
    }
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!std::isfinite(moments.mean())) return {infinity, infinity};
  constexpr double two_sided_99 = 2.5758293035489004;
  return {moments.mean(), two_sided_99 * std::sqrt(moments.variance() / static_cast<double>(draws))};
}

}  // namespace gmis
