#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"

/// \file
/// A small statistical kit for tests of samplers and estimators. A p-value is the chance that a
/// correct program does at least this badly; a test with level a raises a false alarm in a share a
/// of its runs.

namespace gmis {

/// P(a, x) = γ(a, x)/Γ(a), the regularised lower incomplete gamma function, and Q = 1 − P; a > 0, x
/// ≥ 0. Each to about 1e-13 relative, so that small tails keep their digits.
struct RegularisedGamma {
  /// P(a, x), from 0 to x.
  double lower;
  /// Q(a, x) = 1 − P(a, x).
  double upper;
};

/// Both, each without cancellation, for a > 0 and x ≥ 0.
[[nodiscard]] inline RegularisedGamma regularised_gamma(double a, double x) noexcept {
  if (!(x > 0)) return {0, 1};
  if (x == std::numeric_limits<double>::infinity()) return {1, 0};
  constexpr double tiny = 1e-300;
  constexpr double precision = 1e-16;
  const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
  const int most_steps = 1000 + static_cast<int>(20 * std::sqrt(a));
  if (x < a + 1) {  // power series
    double term = 1 / a, sum = term;
    for (int n = 1; n < most_steps && term > sum * precision; ++n) {
      term *= x / (a + n);
      sum += term;
    }
    const double lower = std::min(1.0, sum * scale);
    return {lower, 1 - lower};
  }
  // Continued fraction, by Lentz's method.
  double b = x + 1 - a, c = 1 / tiny, d = 1 / b, h = d;
  for (int n = 1; n < most_steps; ++n) {
    const double numerator = -n * (n - a);
    b += 2;
    d = numerator * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + numerator / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1 / d;
    const double factor = d * c;
    h *= factor;
    if (std::abs(factor - 1) < precision) break;
  }
  const double upper = std::min(1.0, scale * h);
  return {1 - upper, upper};
}

/// I_x(a, b), the regularised incomplete beta function; a, b > 0, x in [0, 1].
[[nodiscard]] inline double regularised_beta(double a, double b, double x) noexcept {
  if (!(x > 0)) return 0;
  if (x >= 1) return 1;
  if (x > (a + 1) / (a + b + 2)) return 1 - regularised_beta(b, a, 1 - x);
  constexpr double tiny = 1e-300;
  const double scale =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  const int most_steps = 1000 + static_cast<int>(20 * std::sqrt(a + b));
  double c = 1, d = 1 - (a + b) * x / (a + 1);
  if (std::abs(d) < tiny) d = tiny;
  d = 1 / d;
  double h = d;
  for (int m = 1; m < most_steps; ++m) {
    double last = 1;
    for (const double numerator : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                                   -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + numerator * d;
      if (std::abs(d) < tiny) d = tiny;
      c = 1 + numerator / c;
      if (std::abs(c) < tiny) c = tiny;
      d = 1 / d;
      last = d * c;
      h *= last;
    }
    if (std::abs(last - 1) < 1e-16) break;
  }
  return scale * h;
}

/// Chance that a standard normal number is below `z`; small tails keep their digits.
[[nodiscard]] inline double normal_cdf(double z) noexcept {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

/// The inverse of `normal_cdf`; ±infinity at 0 and 1, NaN outside.
[[nodiscard]] inline double normal_quantile(double p) noexcept {
  if (!(p >= 0 && p <= 1)) return std::numeric_limits<double>::quiet_NaN();
  if (p == 0 || p == 1)
    return p == 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  if (p > 0.5) return -normal_quantile(1 - p);
  // Start at the tail's leading term or the middle's slope, then Newton on log Φ, which is concave:
  // no overshooting far.
  double z = p < 0.1 ? -std::sqrt(-2 * std::log(p)) : (p - 0.5) * std::sqrt(2 * std::numbers::pi);
  for (int step = 0; step < 60; ++step) {
    const double below = normal_cdf(z);
    const double density = std::exp(-z * z / 2) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    const double change = (std::log(p) - std::log(below)) * below / density;
    z += change;
    if (std::abs(change) <= 1e-15 * std::abs(z)) break;
  }
  return z;
}

/// Chance of at least this χ² statistic with `degrees` of freedom, 1 or more. For a NaN it is 0:
/// the test fails.
[[nodiscard]] inline double chi_square_p_value(double statistic, double degrees) noexcept {
  if (std::isnan(statistic)) return 0;
  return regularised_gamma(degrees / 2, statistic / 2).upper;
}

/// Chance of a t at least this far from 0 on either side, Student's distribution with `degrees` of
/// freedom.
[[nodiscard]] inline double student_t_p_value(double t, double degrees) noexcept {
  return regularised_beta(degrees / 2, 0.5, degrees / (degrees + t * t));
}

/// The t below which Student's distribution with `degrees` of freedom has the share `p`; NaN
/// outside (0, 1).
[[nodiscard]] inline double student_t_quantile(double p, double degrees) noexcept {
  if (!(p > 0 && p < 1)) return std::numeric_limits<double>::quiet_NaN();
  if (p < 0.5) return -student_t_quantile(1 - p, degrees);
  double below = 0, above = 1;
  while (student_t_p_value(above, degrees) / 2 > 1 - p && above < 1e150) {
    below = above;
    above *= 2;
  }
  for (int step = 0; step < 60; ++step) {
    const double middle = (below + above) / 2;
    (student_t_p_value(middle, degrees) / 2 > 1 - p ? below : above) = middle;
  }
  return (below + above) / 2;
}

/// Chance of a standard normal number at least this far from 0 on either side.
[[nodiscard]] inline double normal_p_value(double z) noexcept {
  return std::erfc(std::abs(z) / std::numbers::sqrt2);
}

/// The level for each of `count` independent tests so that all together raise a false alarm with
/// chance `family_level` [Šidák 1967].
[[nodiscard]] inline double sidak_level(double family_level, std::size_t count) noexcept {
  return -std::expm1(std::log1p(-family_level) / static_cast<double>(std::max<std::size_t>(count, 1)));
}

/// The outcome of a test; `degrees_of_freedom` is infinite for a z-test.
struct StatisticalTest {
  double statistic = 0;           ///< χ², t or z
  double degrees_of_freedom = 0;  ///< of the distribution that the statistic follows
  double p_value = 1;             ///< probability of a statistic at least as far off, if nothing is wrong
  /// False when the p-value is below `level`, the false-alarm rate.
  [[nodiscard]] bool passes(double level) const noexcept { return p_value >= level; }
};

/// Is `mean` compatible with `expected`, given its standard error? With no error at all only
/// equality is; with one that is infinite or NaN nothing is, for it tells nothing.
[[nodiscard]] inline StatisticalTest z_test(double mean, double standard_error, double expected) noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!std::isfinite(standard_error)) return {infinity, infinity, 0.0};
  if (!(standard_error > 0)) return {0, infinity, mean == expected ? 1.0 : 0.0};
  const double z = (mean - expected) / standard_error;
  return {z, infinity, normal_p_value(z)};
}

/// `z_test`, but with a standard error that was itself estimated from `count` samples.
[[nodiscard]] inline StatisticalTest t_test(double mean, double standard_error, std::size_t count,
                                            double expected) noexcept {
  const double degrees = static_cast<double>(count) - 1;
  if (!std::isfinite(standard_error)) return {std::numeric_limits<double>::infinity(), degrees, 0.0};
  if (!(standard_error > 0)) return {0, degrees, mean == expected ? 1.0 : 0.0};
  const double t = (mean - expected) / standard_error;
  return {t, degrees, student_t_p_value(t, degrees)};
}

/// Pearson's χ² test of counts against expected counts (same total). Bins that expect less than
/// `smallest_expected` are pooled, from the smallest up. A count where nothing is expected fails
/// the test outright, and so does a count that is NaN. With fewer than two bins left there is
/// nothing to test: p = 1. Throws std::invalid_argument where the numbers of counts and of expected
/// counts differ, and for an expected count that is not finite.
[[nodiscard]] inline StatisticalTest chi_square_test(std::span<const double> observed, std::span<const double> expected,
                                                     double smallest_expected = 5) {
  require_argument(observed.size() == expected.size(), "give one expected count for each count");
  for (const double count : expected) require_argument(std::isfinite(count), "an expected count is not finite");
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  double statistic = 0, pooled_observed = 0, pooled_expected = 0;
  std::size_t bins = 0;
  const auto close_bin = [&] {
    statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    pooled_observed = pooled_expected = 0;
    ++bins;
  };
  for (const std::size_t i : order) {
    if (std::isnan(observed[i]) || (!(expected[i] > 0) && observed[i] > 0))
      return {std::numeric_limits<double>::infinity(), 0, 0};
    pooled_observed += observed[i];
    pooled_expected += expected[i];
    if (pooled_expected >= smallest_expected) close_bin();
  }
  if (pooled_expected > 0) close_bin();
  if (bins < 2) return {0, 0, 1};
  const double degrees = static_cast<double>(bins) - 1;
  return {statistic, degrees, chi_square_p_value(statistic, degrees)};
}

}  // namespace gmis
