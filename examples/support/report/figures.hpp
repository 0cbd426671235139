#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "gmis/result/error_estimate.hpp"
#include "gmis/result/error_fit.hpp"

/// \file
/// The figures of a comparison, from the courses of several runs.

namespace gmis::tools {

/// The courses of one integrator, one per seed, each in the order of time.
using Courses = std::vector<std::vector<ErrorAtTime>>;

/// How long an integrator takes to come down to an error.
struct TimeToError {
  std::optional<double> seconds;  ///< the geometric mean over the seeds; nothing unless every seed reached it
  std::size_t reached = 0;        ///< how many seeds did
  /// Where it was not reached: by the fitted power laws. Nothing if they do not fall, or if it is
  /// more than 100 times as far as was measured: so far a fit says nothing.
  std::optional<double> predicted;
};
[[nodiscard]] TimeToError time_to_error(const Courses& courses, double error);

/// 1 / (error² × time) at the end of each run, over that of another integrator's run with the same
/// number in the list: the geometric mean, and Student's 95 % interval of its logarithm. With one
/// or two seeds the interval is from 0 to infinity: two say nothing of their spread. With none
/// there is nothing.
[[nodiscard]] std::optional<Interval> relative_efficiency(const Courses& courses, const Courses& baseline);

/// The errors that a table asks the time for: the smallest of 1, 2 and 5 in every decade that some
/// integrator came down to (in the mean over its seeds), and the next two above it, the largest
/// first. 5, 2 and 1 % where there are no courses.
[[nodiscard]] std::array<double, 3> targets_of(std::span<const Courses> integrators);

/// The greatest of 1, 2 and 5 in every decade that is at most `value` (positive), and the smallest
/// that is at least `value`.
[[nodiscard]] double round_below(double value);
[[nodiscard]] double round_above(double value);

/// The error at one time: its geometric mean over the seeds, the lowest and the highest.
struct BandPoint {
  double seconds = 0.0;
  double lowest = 0.0;
  double mean = 0.0;
  double highest = 0.0;
};
/// At `count` times, evenly spread in the logarithm over those that every seed covers; between two
/// points of a course the law is a power. Empty when there is no such time.
[[nodiscard]] std::vector<BandPoint> band_of(const Courses& courses, std::size_t count);

/// The mean slope of the power laws fitted to the courses; nothing when none could be fitted.
[[nodiscard]] std::optional<double> mean_slope(const Courses& courses);

/// The geometric mean of the last errors; nothing when there are none.
[[nodiscard]] std::optional<double> last_error(const Courses& courses);

}  // namespace gmis::tools
