#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"

/// \file
/// Sample allocation by variance and cost: fractions α_k for R3, counts n_k for N3, from a table of
/// nodes, which is a quadrature rule or a `PilotSamples`. A cost is that of one sample of proposal
/// k, all its density evaluations included.

namespace gmis {

namespace detail {
inline void check_costs(std::span<const double> costs, std::size_t proposal_count) {
  if (costs.size() != proposal_count && !costs.empty()) reject_argument("give one cost for each proposal, or none");
  for (const double cost : costs)
    if (!(cost > 0.0 && std::isfinite(cost))) reject_argument("costs must be positive numbers");
}
[[nodiscard]] inline double cost_of(std::span<const double> costs, std::size_t k) {
  return costs.empty() ? 1.0 : costs[k];
}
}  // namespace detail

/// Fractions α_k ≥ `least` that minimise (∫ f²/ψ − I²) Σ α_k c_k, ψ = Σ α_k q_k: the variance of R3
/// times its cost. For equal costs the problem is convex [He, Owen: Optimal mixture weights in
/// multiple importance sampling, 2014], and the answer is the minimum; for others it is a
/// stationary point. No step makes the objective larger: ∫ f²/ψ is at most Σ_k (α_k²/α'_k) ∫ f²
/// q_k/ψ² for new fractions α', and that bound has its least value in closed form.
///
/// `least` > 0 (at most 1/N) keeps every proposal in the mixture: a defence against what a pilot
/// has not met. `costs` are positive; none means equal costs. The proposals must cover f together.
/// `tolerance`: how far the objective may be above its minimum, relative to it.
[[nodiscard]] inline std::vector<double> optimal_fractions(const TabulatedProblem& problem,
                                                           std::span<const double> costs = {}, double least = 0.0,
                                                           double tolerance = 1e-6) {
  constexpr std::size_t largest_iterations = 20000;
  const std::size_t n = problem.proposal_count();
  detail::check_costs(costs, n);
  if (!(least >= 0.0 && least * static_cast<double>(n) <= 1.0))
    reject_argument("the least fraction must lie between 0 and 1/N");
  std::vector<double> fractions(n, 1.0 / static_cast<double>(n)), bound(n), psi(problem.node_count());
  const double integral = problem.integral();
  for (std::size_t iteration = 0; iteration < largest_iterations; ++iteration) {
    std::fill(psi.begin(), psi.end(), 0.0);
    for (std::size_t k = 0; k < n; ++k)
      if (fractions[k] > 0.0) problem.add_density(k, fractions[k], psi.data(), psi.data());
    double second = 0.0, cost = 0.0;
    std::fill(bound.begin(), bound.end(), 0.0);
    for (std::size_t i = 0; i < psi.size(); ++i) {
      if (!(psi[i] > 0.0)) continue;
      const double value = problem.values()[i] / psi[i];
      const double square = problem.weights()[i] * value * value;
      second += square * psi[i];
      for (std::size_t k = 0; k < n; ++k) bound[k] += square * problem.densities(k)[i];
    }
    for (std::size_t k = 0; k < n; ++k) cost += fractions[k] * detail::cost_of(costs, k);
    const double variance = second - integral * integral;
    if (!(variance > 1e-14 * second)) break;  // f is proportional to ψ

    // The logarithm of the objective falls at the rate b_k/V − c_k/C as α_k grows: it can gain no
    // more (for equal costs, by convexity; for others to first order) than on the way to the best
    // corner.
    double steepest = -std::numeric_limits<double>::infinity(), everywhere = 0.0, here = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double slope = bound[k] / variance - detail::cost_of(costs, k) / cost;
      steepest = std::max(steepest, slope);
      everywhere += slope;
      here += fractions[k] * slope;
    }
    if ((1.0 - least * static_cast<double>(n)) * steepest + least * everywhere - here < tolerance) break;

    // Minimise Σ α² b_k/(α' V) + Σ α' c_k/C over Σ α' = 1: α'_k = α_k sqrt(b_k/V/(c_k/C + μ)), μ by
    // bisection.
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < n; ++k) lowest = std::min(lowest, detail::cost_of(costs, k) / cost);
    const auto sum_for = [&](double mu, bool write) {
      double sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        const double price = detail::cost_of(costs, k) / cost + mu;
        const double next = std::max(least, fractions[k] * std::sqrt(bound[k] / variance / price));
        if (write) fractions[k] = next;
        sum += next;
      }
      return sum;
    };
    double low = -lowest, high = 1.0;
    while (sum_for(high, false) > 1.0) high *= 2.0;
    for (int step = 0; step < 200 && high - low > 1e-16 * (1.0 + std::abs(high)); ++step) {
      const double middle = 0.5 * (low + high);
      (sum_for(middle, false) > 1.0 ? low : high) = middle;
    }
    const double sum = sum_for(high, true);
    for (double& fraction : fractions) fraction = std::max(least, fraction / sum);
  }
  return fractions;
}

/// A rule without iterations: α_k in proportion to 1/(c_k V_k), V_k = ∫ f²/q_k − I² being the
/// variance of proposal k alone [Sbert, Havran, Szirmay-Kalos 2016, 2018]. Proposals that do not
/// cover f alone get nothing (a tail that no node shows counts as covered), so that a defensive
/// part should be mixed in; where none covers f, all fractions are equal. Proposals without
/// variance share all samples equally.
[[nodiscard]] inline std::vector<double> inverse_variance_fractions(const TabulatedProblem& problem,
                                                                    std::span<const double> costs = {}) {
  const std::size_t n = problem.proposal_count();
  detail::check_costs(costs, n);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> works(n, infinity), alone(n);  // c_k V_k
  for (std::size_t k = 0; k < n; ++k) {
    if (!problem.covers(problem.densities(k))) continue;
    std::fill(alone.begin(), alone.end(), 0.0);
    alone[k] = 1.0;
    const double variance = exact_moments_of_mixture(alone, 1, problem).variance;
    if (std::isfinite(variance)) works[k] = detail::cost_of(costs, k) * std::max(variance, 0.0);
  }
  const double least = *std::min_element(works.begin(), works.end());
  if (least == infinity) return std::vector<double>(n, 1.0 / static_cast<double>(n));
  std::vector<double> fractions(n);
  double sum = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (works[k] < infinity) fractions[k] = works[k] == least ? 1.0 : least / works[k];
    sum += fractions[k];
  }
  for (double& fraction : fractions) fraction /= sum;
  return fractions;
}

/// Counts n_k, `total` in all, that make variance × cost of N3 small, by the exact variance: from
/// the best of the rounded `optimal_fractions` and equal counts, samples move from one proposal to
/// another as long as that gains. Counts that leave a part of f uncovered are not considered. A
/// local minimum. Throws std::invalid_argument when there are none (a total below the number of
/// proposals that it takes to cover f).
[[nodiscard]] inline std::vector<std::uint32_t> optimal_counts(const TabulatedProblem& problem, std::size_t total,
                                                               std::span<const double> costs = {}) {
  const std::size_t n = problem.proposal_count();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (total == 0) reject_argument("give a round at least one sample");
  const auto objective = [&](std::span<const std::uint32_t> counts) {
    if (!problem.covers(mixture_of(fractions_of(counts), problem).data())) return infinity;
    double cost = 0.0;
    for (std::size_t k = 0; k < n; ++k) cost += counts[k] * detail::cost_of(costs, k);
    const double value = exact_moments(counts, problem).variance * cost;
    return std::isfinite(value) ? value : infinity;
  };
  std::vector<std::uint32_t> best(n), counts(n);
  const std::vector<double> equal(n, 1.0), fractions = optimal_fractions(problem, costs, 0.0, 1e-3);
  apportion<double>(fractions, total, best);
  apportion<double>(equal, total, counts);
  double least = objective(best);
  if (const double value = objective(counts); value < least) {
    least = value;
    best = counts;
  }
  for (std::uint32_t step = static_cast<std::uint32_t>(total / (2 * n) + 1); step > 0; step /= 2)
    for (bool gained = true; gained;) {
      gained = false;
      for (std::size_t from = 0; from < n; ++from)
        for (std::size_t to = 0; to < n; ++to) {
          if (from == to || best[from] < step) continue;
          counts = best;
          counts[from] -= step;
          counts[to] += step;
          const double value = objective(counts);
          if (value < least * (1.0 - 1e-12)) {
            least = value;
            best = counts;
            gained = true;
          }
        }
    }
  if (least == infinity) reject_argument("no counts with this total cover the integrand: give a larger total");
  return best;
}

}  // namespace gmis
