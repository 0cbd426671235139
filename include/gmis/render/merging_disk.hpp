#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "gmis/core/math.hpp"
#include "gmis/transport/allocation/forecast.hpp"

namespace gmis {

/// The number of iterations after which disk and gain of merging are chosen next, when `done` have
/// been made: 4, 32, 256 and so on, and `expected`, the number that the pilot was told. Ranks wait
/// for each other there, and choosing at 8, 16, 64 and 128, too, does not lower the error.
[[nodiscard]] constexpr std::uint32_t next_choice_of_merging(std::uint32_t done, std::uint32_t expected) noexcept {
  std::uint64_t next = 4;
  while (next <= done) next *= 8;
  if (expected > std::max(done, 4U)) next = std::min<std::uint64_t>(next, expected);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(next, std::numeric_limits<std::uint32_t>::max()));
}

/// The merging of a run so far.
struct DisksSoFar {
  std::uint32_t iterations = 0;  ///< number of iterations so far
  double area = 0.0;             ///< sum of the squared radii of all iterations
  double squared_bias = 0.0;     ///< of the mean of all iterations, relative; 0 where none is known
};

/// The r_1² with the least mean squared error at the end of the run. The run has `iterations` in
/// all, and those that are left have the disks r_1² i^(α−1). An iteration has the variance
/// `merging` / r² because of merging, and the bias of a disk is proportional to r²:
///     Σ merging / r_i² / N² + c² (Σ r_i² / N)²,
/// whose derivative vanishes at one place. Infinite when no bias is known.
[[nodiscard]] inline double best_first_disk(const DisksSoFar& so_far, double merging, double alpha,
                                            std::uint32_t iterations) {
  // Of the iterations left, for r_1 = 1: the sums of i^(α−1) and of i^(1−α).
  const auto sum = [&](double exponent) {
    return iterations * mean_disk(exponent, iterations) - so_far.iterations * mean_disk(exponent, so_far.iterations);
  };
  const double areas = sum(alpha), inverses = sum(2.0 - alpha);
  const double bias_of_disk = so_far.squared_bias * square(so_far.iterations / so_far.area);  // c²
  if (!(bias_of_disk * areas > 0.0)) return std::numeric_limits<double>::infinity();
  // u² (area + areas u) = wanted, for u = r_1².
  const double wanted = 0.5 * merging * inverses / (bias_of_disk * areas);
  double lower = 0.0, upper = std::cbrt(wanted / areas);
  for (int step = 0; step < 100 && lower < upper; ++step) {
    const double u = 0.5 * (lower + upper);
    (square(u) * (so_far.area + areas * u) < wanted ? lower : upper) = u;
  }
  return 0.5 * (lower + upper);
}

}  // namespace gmis
