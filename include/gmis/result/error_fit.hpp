#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

namespace gmis {

/// One error and the time it took to come down to it, in seconds or in iterations: what is fitted
/// to such points speaks in the same unit.
struct ErrorAtTime {
  double seconds = 0.0;  ///< time, or iterations
  double error = 0.0;    ///< error at that time
};

/// error = error_at_one · seconds^slope. The slope is −1/2 for independent iterations of equal
/// variance; it is flatter where merging shrinks its radius, and where a bias or the noise of the
/// reference is what remains. Nothing falls faster for long: what looks steeper is chance.
struct PowerLaw {
  double slope = -0.5;        ///< exponent of the time
  double error_at_one = 0.0;  ///< error after one second, or one iteration
  bool is_fitted = false;     ///< false: too little was known, the slope is taken to be −1/2

  /// The error after this time.
  [[nodiscard]] double error_at(double seconds) const noexcept { return error_at_one * std::pow(seconds, slope); }

  /// When the error will be down to `error`; infinite when it does not fall (a slope above −0.02).
  [[nodiscard]] double seconds_to_reach(double error) const noexcept {
    if (!(slope < -0.02) || !(error_at_one > 0.0)) return std::numeric_limits<double>::infinity();
    return std::pow(error / error_at_one, 1.0 / slope);
  }
};

/// The power law through the later part of a log, by least squares in logarithms. The points are to
/// be in the order of time and about evenly spread over its logarithm, as those of a
/// `ConvergenceLog` are. Points before 1/16 of the last time are left out: the beginning of a run
/// (pilots, cold caches, estimates from few iterations) says little about its course. With fewer
/// than 4 points left, or less than a fourfold span of time, the slope is −1/2 through the last
/// point. Nothing without a positive error at a positive time.
[[nodiscard]] inline std::optional<PowerLaw> fit_power_law(std::span<const ErrorAtTime> points) {
  const auto is_usable = [](const ErrorAtTime& point) {
    return point.seconds > 0.0 && point.error > 0.0 && std::isfinite(point.seconds) && std::isfinite(point.error);
  };
  const ErrorAtTime* last = nullptr;
  for (const ErrorAtTime& point : points)
    if (is_usable(point)) last = &point;
  if (last == nullptr) return {};

  double count = 0.0, x_mean = 0.0, y_mean = 0.0, first = last->seconds;
  const auto is_used = [&](const ErrorAtTime& point) {
    return is_usable(point) && point.seconds >= last->seconds / 16;
  };
  for (const ErrorAtTime& point : points)
    if (is_used(point)) {
      count += 1.0;
      x_mean += std::log(point.seconds);
      y_mean += std::log(point.error);
      first = std::min(first, point.seconds);
    }
  if (count < 4.0 || last->seconds < 4.0 * first) return PowerLaw{-0.5, last->error * std::sqrt(last->seconds), false};
  x_mean /= count;
  y_mean /= count;
  double xx = 0.0, xy = 0.0;
  for (const ErrorAtTime& point : points)
    if (is_used(point)) {
      const double x = std::log(point.seconds) - x_mean;
      xx += x * x;
      xy += x * (std::log(point.error) - y_mean);
    }
  const double slope = std::max(-0.5, xy / xx);
  return PowerLaw{slope, std::exp(y_mean - slope * x_mean), true};
}

/// When the error first was down to `error` and stayed there, from the points of a log in the order
/// of time; between two points the law is a power. Nothing when it was not reached.
[[nodiscard]] inline std::optional<double> seconds_until(std::span<const ErrorAtTime> points, double error) {
  std::size_t first_below = points.size();
  while (first_below > 0 && points[first_below - 1].error <= error) --first_below;
  if (first_below == points.size()) return {};
  const ErrorAtTime& after = points[first_below];
  if (first_below == 0 || !(after.error > 0.0)) return after.seconds;
  const ErrorAtTime& before = points[first_below - 1];
  const double share = std::log(before.error / error) / std::log(before.error / after.error);
  return before.seconds * std::pow(after.seconds / before.seconds, share);
}

}  // namespace gmis
