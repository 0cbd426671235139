#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/diagnostics/tabulated_problem.hpp"

namespace gmis {

/// How well a quadrature rule fits a problem: exact variances over a rule that cuts a tail off, or
/// has too few points, are the exact answers to another question.
struct ProblemCheck {
  std::vector<double> density_integrals;  ///< ∫ q_i over the finer rule: one, or the probability that a sample is made
  double integral = 0.0;                  ///< ∫ f by the finer rule
  double integral_change = 0.0;           ///< |difference between the rules| over ∫ |f|
  double variance_change = 0.0;           ///< |difference between the rules' variances of N3| over ∫ f²/(N ψ)
  double end_share = 0.0;                 ///< share of ∫ |f| in the first and last 1 % of the nodes of the finer rule
  double end_share_of_mixture = 0.0;      ///< share of ψ there
  bool can_fail = false;                  ///< a `sample` may return nothing, so that ∫ q_i may be below one

  /// The first finding as a sentence; empty when nothing is wrong. `tolerance`: greatest deviation
  /// of ∫ q_i from one, and greatest value of both changes. A share of f at the ends is a finding
  /// above `tolerance` where the mixture has less than a hundredth of that share there: the range
  /// ends where f does not, and the proposals know nothing of it.
  [[nodiscard]] std::string_view finding(double tolerance = 1e-6) const noexcept {
    for (const double mass : density_integrals) {
      if (mass > 1.0 + tolerance) return "a density integrates to more than one: too few nodes, or no density";
      if (mass < 1.0 - tolerance && !can_fail)
        return "a density integrates to less than one: the range cuts it off, or too few nodes";
    }
    if (!(integral_change <= tolerance))
      return "the finer rule has another integral: too few nodes, or an infinite one";
    if (!(variance_change <= tolerance))
      return "the finer rule has another variance of N3: too few nodes, or an infinite one";
    if (end_share > tolerance && end_share_of_mixture < 0.01 * end_share)
      return "the integrand has mass at the ends of the range, where the proposals have none: the range cuts it off";
    return {};
  }
  /// True when there is no finding.
  [[nodiscard]] bool passes(double tolerance = 1e-6) const noexcept { return finding(tolerance).empty(); }
};

/// Compares a rule with a finer one over the same range, and looks for what lies outside the range.
/// f has one channel. Nodes on the line are taken in their order for the shares at the ends; for
/// other nodes these are 0.
template <class Integrand, class P, NodeRange Nodes>
[[nodiscard]] ProblemCheck check_problem(Integrand&& f, const P& proposals, const Nodes& nodes, const Nodes& finer) {
  const TabulatedProblem coarse(f, proposals, nodes), fine(f, proposals, finer);
  ProblemCheck check;
  using Set = std::remove_cvref_t<decltype(as_proposal_set(proposals))>;
  check.can_fail = SampleResult<std::remove_cvref_t<decltype(std::declval<const Set&>().sample(
      std::size_t{}, std::declval<Philox&>()))>>::can_fail;
  const std::size_t n = fine.proposal_count(), count = fine.node_count();
  for (std::size_t i = 0; i < n; ++i) {
    double mass = 0.0;
    for (std::size_t node = 0; node < count; ++node) mass += fine.weights()[node] * fine.densities(i)[node];
    check.density_integrals.push_back(mass);
  }
  const std::vector<double> psi = mixture_of(std::vector<double>(n, 1.0 / static_cast<double>(n)), fine);
  double absolute = 0.0, second = 0.0, mass = 0.0;
  for (std::size_t node = 0; node < count; ++node) {
    const double value = std::abs(fine.values()[node]);
    absolute += fine.weights()[node] * value;
    mass += fine.weights()[node] * psi[node];
    if (psi[node] > 0.0) second += fine.weights()[node] * value * (value / psi[node]);
  }
  check.integral = fine.integral();
  if (absolute > 0.0) check.integral_change = std::abs(fine.integral() - coarse.integral()) / absolute;
  if (second > 0.0)
    check.variance_change = std::abs(exact_variance(Scheme::N3, fine) - exact_variance(Scheme::N3, coarse)) *
                            static_cast<double>(n) / second;
  if constexpr (std::is_floating_point_v<std::remove_cvref_t<decltype(std::begin(finer)->x)>>) {
    const std::size_t end = std::min((count + 99) / 100, count / 2);
    for (std::size_t node = 0; node < count; ++node) {
      if (node >= end && node + end < count) continue;
      if (absolute > 0.0) check.end_share += fine.weights()[node] * std::abs(fine.values()[node]) / absolute;
      if (mass > 0.0) check.end_share_of_mixture += fine.weights()[node] * psi[node] / mass;
    }
  }
  return check;
}

}  // namespace gmis
