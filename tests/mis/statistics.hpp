#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"

namespace test {

using gmis::normal_p_value;
using gmis::sidak_level;

struct SampleMoments {
  double mean = 0.0;
  double variance = 0.0;
  double standard_error = 0.0;
};

/// In two passes, long double.
inline SampleMoments moments_of(const std::vector<double>& values) {
  const long double n = static_cast<long double>(values.size());
  long double sum = 0.0L, squares = 0.0L;
  for (const double v : values) sum += v;
  const long double mean = sum / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const long double variance = squares / (n - 1.0L);
  return {static_cast<double>(mean), static_cast<double>(variance), static_cast<double>(std::sqrt(variance / n))};
}

/// p-value that values with this mean have the expectation `truth`.
inline double mean_p_value(const SampleMoments& m, double truth) {
  // Differences at the level of rounding are no evidence; they arise when all values are equal.
  if (std::abs(m.mean - truth) <= 1e-12 * std::abs(truth)) return 1.0;
  return m.standard_error > 0.0 ? normal_p_value((m.mean - truth) / m.standard_error) : 0.0;
}

/// p-value of the two-sample Kolmogorov–Smirnov test (asymptotic series, Stephens' correction).
inline double kolmogorov_smirnov_p_value(std::vector<double> a, std::vector<double> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::size_t i = 0, j = 0;
  double distance = 0.0;
  while (i < a.size() && j < b.size()) {
    const double value = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= value) ++i;
    while (j < b.size() && b[j] <= value) ++j;
    distance = std::max(distance, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                           static_cast<double>(j) / static_cast<double>(b.size())));
  }
  const double root = std::sqrt(static_cast<double>(a.size()) * static_cast<double>(b.size()) /
                                static_cast<double>(a.size() + b.size()));
  const double lambda = (root + 0.12 + 0.11 / root) * distance;
  if (lambda < 0.2) return 1.0;
  double p = 0.0;
  for (int term = 1; term <= 100; ++term)
    p += (term % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * lambda * lambda * term * term);
  return std::clamp(p, 0.0, 1.0);
}

/// The z that |standard normal| exceeds with probability `p_value`.
inline double normal_two_sided_quantile(double p_value) {
  double low = 0.0, high = 40.0;
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    (normal_p_value(middle) > p_value ? low : high) = middle;
  }
  return low;
}

/// The interval, at the given two-sided false-alarm rate, for the variance that values were drawn
/// with: sample variance ± z standard errors, the standard error found by bootstrap.
struct Interval {
  double low, high;
  bool contains(double value) const { return low <= value && value <= high; }
  double relative_half_width() const { return (high - low) / (high + low); }
};
inline Interval bootstrap_variance_interval(const std::vector<double>& values, double false_alarm_rate,
                                            gmis::UniformSource auto& source) {
  constexpr std::size_t resamples = 100;
  const auto n = static_cast<std::uint32_t>(values.size());
  const SampleMoments sample = moments_of(values);
  std::vector<double> variances(resamples);
  for (double& variance : variances) {
    double sum = 0.0, squares = 0.0;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double v = values[gmis::uniform_index(source, n)] - sample.mean;
      sum += v;
      squares += v * v;
    }
    variance = (squares - sum * sum / n) / (n - 1.0);
  }
  const double half_width = normal_two_sided_quantile(false_alarm_rate) * std::sqrt(moments_of(variances).variance);
  return {sample.variance - half_width, sample.variance + half_width};
}

}  // namespace test
