#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../../examples/mis/four_problems.hpp"
#include "gmis/mis/diagnostics/tabulated_problem.hpp"
#include "mis/statistics.hpp"
#include "support/seed.hpp"

/// Oracles for the methods on the four problems: integrals in long double by Gauss's rule of five
/// points (Abramowitz, Stegun 25.4.29) over many panels. Nothing of the library is used.
namespace test {

template <class G>
long double integral_over(const std::vector<double>& breakpoints, G g) {
  const long double a = std::sqrt(5.0L - 2.0L * std::sqrt(10.0L / 7.0L)) / 3.0L;
  const long double b = std::sqrt(5.0L + 2.0L * std::sqrt(10.0L / 7.0L)) / 3.0L;
  const long double wa = (322.0L + 13.0L * std::sqrt(70.0L)) / 900.0L,
                    wb = (322.0L - 13.0L * std::sqrt(70.0L)) / 900.0L;
  const std::array<long double, 5> places{-b, -a, 0.0L, a, b}, weights{wb, wa, 128.0L / 225.0L, wa, wb};
  constexpr int panels = 400;
  long double sum = 0.0L;
  for (std::size_t interval = 0; interval + 1 < breakpoints.size(); ++interval) {
    const long double low = breakpoints[interval], high = breakpoints[interval + 1];
    const long double half = (high - low) / (2 * panels);
    for (int panel = 0; panel < panels; ++panel)
      for (std::size_t i = 0; i < 5; ++i)
        sum += half * weights[i] *
               static_cast<long double>(g(static_cast<double>(low + half * (2 * panel + 1 + places[i]))));
  }
  return sum;
}
template <class G>
long double integral(const four::Problem& problem, G g) {
  return integral_over(problem.breakpoints, g);
}

/// Mean and variance of Σ_k Σ_{i ≤ n_k} h_k(x_ki) from the definition; `h(k, x)` in long double.
struct LongMoments {
  long double mean, variance;
};
template <class H>
LongMoments moments_by_definition(const four::Problem& problem, const std::vector<std::uint32_t>& counts, H h) {
  LongMoments result{0.0L, 0.0L};
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] == 0) continue;
    const auto q = [&](double x) { return static_cast<long double>(problem.proposals[k].pdf(x)); };
    const long double mean = integral(problem, [&](double x) { return q(x) > 0.0L ? q(x) * h(k, x) : 0.0L; });
    const long double variance = integral(problem, [&](double x) {
      if (!(q(x) > 0.0L)) return 0.0L;
      const long double difference = h(k, x) - mean;
      return q(x) * difference * difference;
    });
    result.mean += counts[k] * mean;
    result.variance += counts[k] * variance;
  }
  return result;
}

/// Σ n_k q_k(x).
inline long double expected_density(const four::Problem& problem, const std::vector<std::uint32_t>& counts, double x) {
  long double sum = 0.0L;
  for (std::size_t k = 0; k < counts.size(); ++k)
    sum += counts[k] * static_cast<long double>(problem.proposals[k].pdf(x));
  return sum;
}

inline gmis::TabulatedProblem tabulated(const four::Problem& problem) {
  return {problem.f, problem.proposals, problem.nodes()};
}

/// Counts that differ, all positive: 1, 3, 2, 1, 3, 2, …
inline std::vector<std::uint32_t> uneven_counts(const four::Problem& problem) {
  std::vector<std::uint32_t> counts;
  for (std::size_t k = 0; k < problem.proposals.size(); ++k) counts.push_back(k % 3 == 0 ? 1 : k % 3 == 1 ? 3 : 2);
  return counts;
}

}  // namespace test
