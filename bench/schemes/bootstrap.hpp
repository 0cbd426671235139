#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/core/random.hpp"

namespace bench {

struct MeasuredVariance {
  double value, low, high;  ///< and its 95 % interval
};

/// Sample variance and the percentile interval of 400 bootstrap resamples. Below its nominal level when the tails are heavy.
[[nodiscard]] inline MeasuredVariance bootstrap_variance(const std::vector<double>& values, std::uint64_t seed) {
  const auto n = static_cast<std::uint32_t>(values.size());
  const double count = static_cast<double>(n);
  double mean = 0.0;
  for (const double v : values) mean += v / count;
  gmis::Philox source(seed);
  const auto variance_of = [&](auto value_at) {
    double sum = 0.0, squares = 0.0;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double v = value_at(i) - mean;
      sum += v;
      squares += v * v;
    }
    return (squares - sum * sum / count) / (count - 1.0);
  };
  constexpr std::size_t resamples = 400;
  std::vector<double> variances(resamples);
  for (double& variance : variances)
    variance = variance_of([&](std::uint32_t) { return values[gmis::uniform_index(source, n)]; });
  std::sort(variances.begin(), variances.end());
  return {variance_of([&](std::uint32_t i) { return values[i]; }), variances[resamples / 40],
          variances[resamples - 1 - resamples / 40]};
}

}  // namespace bench
