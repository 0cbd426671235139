#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"

namespace gmis {

/// Mean and variance of an estimator beside the exact ones, with the errors that the check is able
/// to see.
struct EstimatorCheck {
  std::uint64_t rounds = 0;       ///< independent rounds that were run
  std::uint64_t not_finite = 0;   ///< rounds whose value was NaN or infinite; one of them fails the check
  double level = 0.0;             ///< false-alarm rate of both tests together
  ExactMoments exact{};           ///< of one round
  double mean = 0.0;              ///< measured; NaN with fewer than two finite rounds, like `variance`
  double variance = 0.0;          ///< of one round, measured about the exact mean
  StatisticalTest mean_test;      ///< z, with the exact variance
  StatisticalTest variance_test;  ///< t, its p-value corrected for the skewness of the squared deviations [Hall 1992]
  double smallest_mean_error = 0.0;      ///< relative error of the mean that is seen with a probability of 99 %
  double smallest_variance_error = 0.0;  ///< relative error of the variance that is seen with a probability of 99 %

  /// True when neither test finds anything: a sound estimator fails with the probability `level`.
  [[nodiscard]] bool passes() const noexcept {
    const double each = sidak_level(level, 2);
    return not_finite == 0 && mean_test.passes(each) && variance_test.passes(each);
  }
  /// Figures and power, in three lines.
  [[nodiscard]] std::string text() const {
    std::string result;
    const auto line = [&](const char* name, double measured, double expected, const char* letter,
                          const StatisticalTest& test, double seen) {
      char buffer[256];
      std::snprintf(buffer, sizeof(buffer),
                    "%-8s  measured %-12.6g exact %-12.6g %s = %-8.3g p = %-8.2g sees an error of %.2g %%\n", name,
                    measured, expected, letter, test.statistic, test.p_value, 100.0 * seen);
      result += buffer;
    };
    line("mean", mean, exact.mean, "z", mean_test, smallest_mean_error);
    line("variance", variance, exact.variance, "t", variance_test, smallest_variance_error);
    char buffer[160];
    std::snprintf(buffer, sizeof(buffer), "%llu rounds, %llu of them not finite, false-alarm rate %g: %s\n",
                  static_cast<unsigned long long>(rounds), static_cast<unsigned long long>(not_finite), level,
                  passes() ? "passes" : "FAILS");
    return result + buffer;
  }
};

/// Runs an estimator and tests its mean and its variance against exact ones, as one family of two
/// tests [Šidák 1967] with the false-alarm rate `level`. A wrong weight that leaves the estimator
/// unbiased, and an error of the mean below the noise, show in the variance.
///
/// `round()` returns the estimate of one round, independent of the other rounds; `exact` is from
/// `exact_moments`, `moments_of_contributions` or a closed form. The variance of a variance is
/// measured in the same rounds: with heavy tails more than 10,000 rounds keep the stated rate, and
/// with an infinite fourth moment no number does. A measured variance that overflows fails the
/// check. Throws std::invalid_argument for fewer than 100 rounds, a level outside ]0, 1[ and exact
/// moments that are not finite.
template <class Round>
requires requires(Round& round) {
  { round() } -> std::convertible_to<double>;
}
[[nodiscard]] EstimatorCheck check_estimator(Round&& round, const ExactMoments& exact, std::uint64_t rounds = 100'000,
                                             double level = 1e-4) {
  require_argument(rounds >= 100, "check_estimator needs at least 100 rounds");
  require_argument(level > 0.0 && level < 1.0, "a false-alarm rate lies between 0 and 1");
  require_argument(std::isfinite(exact.mean) && std::isfinite(exact.variance) && exact.variance >= 0.0,
                   "the exact mean and variance must be finite: no number of rounds could be tested against them");
  EstimatorCheck check;
  check.rounds = rounds;
  check.level = level;
  check.exact = exact;
  std::vector<double> values;
  values.reserve(rounds);
  for (std::uint64_t i = 0; i < rounds; ++i) {
    const double value = static_cast<double>(round());
    if (std::isfinite(value))
      values.push_back(value);
    else
      ++check.not_finite;
  }
  const double n = static_cast<double>(values.size());
  if (values.size() < 2) {
    check.mean = check.variance = std::numeric_limits<double>::quiet_NaN();
    check.mean_test.p_value = check.variance_test.p_value = 0.0;
    return check;
  }

  // About the exact mean: nothing cancels, and squared deviations are independent of each other.
  // About the measured mean, those of two equally likely values would all err alike. Relative to
  // the exact standard deviation, so that their sixth powers stay within the range of double.
  const double scale = exact.variance > 0.0 ? std::sqrt(exact.variance) : 1.0;
  const double expected = exact.variance > 0.0 ? 1.0 : 0.0;
  double sum = 0.0, square = 0.0;
  for (double& value : values) {
    value = (value - exact.mean) / scale;
    sum += value;
    value *= value;
    square += value;
  }
  const double offset = sum / n * scale;
  check.mean = exact.mean + offset;
  const double second = square / n;
  check.variance = second * scale * scale;
  double spread = 0.0, cubes = 0.0;
  for (const double value : values) {
    const double difference = value - second;
    spread += difference * difference;
    cubes += difference * difference * difference;
  }
  const double deviation = std::sqrt(spread / n);  // of one squared deviation

  // A variance of 0 leaves rounding errors, which are no evidence.
  const double rounding = 1e-12 * std::max(std::abs(exact.mean), std::abs(check.mean));
  const double z_seen =
      normal_quantile(1.0 - sidak_level(level, 2) / 2.0) + normal_quantile(0.99);  // a shift seen in 99 of 100
  const double mean_error = std::sqrt(exact.variance) / std::sqrt(n);
  check.mean_test = std::isfinite(offset) && std::abs(offset) <= rounding
                        ? StatisticalTest{0.0, std::numeric_limits<double>::infinity(), 1.0}
                        : z_test(check.mean, mean_error, exact.mean);
  if (exact.mean != 0.0) check.smallest_mean_error = z_seen * mean_error / std::abs(exact.mean);
  const double relative_mean = exact.mean / scale;
  const double largest_variance = std::max(second, expected);
  const double no_variance = std::max(1e-14 * relative_mean * relative_mean, 1e-9 * largest_variance);
  if (deviation <= 1e-9 * largest_variance || largest_variance <= no_variance) {
    // Squares that overflow are no evidence of the variance.
    const bool same = std::isfinite(second) && std::abs(second - expected) <= no_variance;
    check.variance_test = {0.0, std::numeric_limits<double>::infinity(), same ? 1.0 : 0.0};
  } else {
    const double skewness = cubes / n / (deviation * deviation * deviation);
    const double s = (second - expected) / deviation;
    const double transformed =
        s + skewness * s * s / 3.0 + skewness * skewness * s * s * s / 27.0 + skewness / (6.0 * n);
    check.variance_test = {std::sqrt(n) * s, std::numeric_limits<double>::infinity(),
                           normal_p_value(std::sqrt(n) * transformed)};
    if (exact.variance > 0.0) check.smallest_variance_error = z_seen * deviation / std::sqrt(n);
  }
  return check;
}

}  // namespace gmis
