#include "support/report/figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gmis/core/statistics.hpp"

namespace gmis::tools {

namespace {

/// The points with a positive error at a positive time.
std::vector<ErrorAtTime> usable(const std::vector<ErrorAtTime>& course) {
  std::vector<ErrorAtTime> points;
  for (const ErrorAtTime& point : course)
    if (point.seconds > 0 && point.error > 0 && std::isfinite(point.error)) points.push_back(point);
  return points;
}

/// Within the times of `points`, which are not empty.
double error_at(std::span<const ErrorAtTime> points, double seconds) {
  const auto after = std::lower_bound(points.begin(), points.end(), seconds,
                                      [](const ErrorAtTime& point, double time) { return point.seconds < time; });
  if (after == points.begin()) return points.front().error;
  if (after == points.end()) return points.back().error;
  const ErrorAtTime& before = *(after - 1);
  if (after->seconds <= before.seconds) return after->error;
  const double share = std::log(seconds / before.seconds) / std::log(after->seconds / before.seconds);
  return before.error * std::pow(after->error / before.error, share);
}

}  // namespace

TimeToError time_to_error(const Courses& courses, double error) {
  TimeToError result;
  constexpr double farthest = 100;
  double log_sum = 0, log_predicted = 0, measured = 0;
  for (const auto& course : courses) {
    const auto points = usable(course);
    if (!points.empty()) measured = std::max(measured, points.back().seconds);
    if (const auto seconds = seconds_until(points, error)) {
      ++result.reached;
      log_sum += std::log(*seconds);
      log_predicted += std::log(*seconds);
    } else if (const auto law = fit_power_law(points)) {
      log_predicted += std::log(law->seconds_to_reach(error));
    } else {
      log_predicted = std::numeric_limits<double>::infinity();
    }
  }
  const auto count = static_cast<double>(courses.size());
  if (courses.empty()) return result;
  if (result.reached == courses.size())
    result.seconds = std::exp(log_sum / count);
  else if (std::exp(log_predicted / count) <= farthest * measured)
    result.predicted = std::exp(log_predicted / count);
  return result;
}

std::optional<Interval> relative_efficiency(const Courses& courses, const Courses& baseline) {
  std::vector<double> logs;
  for (std::size_t i = 0; i < std::min(courses.size(), baseline.size()); ++i) {
    const auto ours = usable(courses[i]), theirs = usable(baseline[i]);
    if (ours.empty() || theirs.empty()) continue;
    const auto log_cost = [](const ErrorAtTime& end) { return 2 * std::log(end.error) + std::log(end.seconds); };
    logs.push_back(log_cost(theirs.back()) - log_cost(ours.back()));
  }
  if (logs.empty()) return {};
  const auto count = static_cast<double>(logs.size());
  double mean = 0, squares = 0;
  for (const double value : logs) mean += value / count;
  for (const double value : logs) squares += (value - mean) * (value - mean);
  if (logs.size() < 3) return Interval{std::exp(mean), 0, std::numeric_limits<double>::infinity()};
  const double reach = student_t_quantile(0.975, count - 1) * std::sqrt(squares / (count - 1) / count);
  return Interval{std::exp(mean), std::exp(mean - reach), std::exp(mean + reach)};
}

double round_below(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  double found = decade;
  // A value that is one of them but for its rounding is that one.
  for (const double step : {1.0, 2.0, 5.0, 10.0})
    if (step * decade <= value * (1 + 1e-9)) found = step * decade;
  return found;
}

double round_above(double value) {
  const double below = round_below(value);
  if (below >= value * (1 - 1e-9)) return below;
  return round_below(below * 2.5 * (1 + 1e-6));
}

std::array<double, 3> targets_of(std::span<const Courses> integrators) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Courses& courses : integrators)
    if (const auto error = last_error(courses); error && *error > 0) smallest = std::min(smallest, *error);
  if (!std::isfinite(smallest)) return {0.05, 0.02, 0.01};
  const double least = round_above(smallest), next = round_above(least * 1.5), most = round_above(next * 1.5);
  return {most, next, least};
}

std::vector<BandPoint> band_of(const Courses& courses, std::size_t count) {
  Courses usable_courses;
  double first = 0, last = std::numeric_limits<double>::infinity();
  for (const auto& course : courses) {
    auto points = usable(course);
    if (points.empty()) return {};
    first = std::max(first, points.front().seconds);
    last = std::min(last, points.back().seconds);
    usable_courses.push_back(std::move(points));
  }
  std::vector<BandPoint> band;
  if (usable_courses.empty() || !(first <= last) || count < 2) return band;
  for (std::size_t i = 0; i < count; ++i) {
    const double seconds = first * std::pow(last / first, static_cast<double>(i) / static_cast<double>(count - 1));
    BandPoint point{seconds, std::numeric_limits<double>::infinity(), 0, 0};
    for (const auto& course : usable_courses) {
      const double error = error_at(course, seconds);
      point.lowest = std::min(point.lowest, error);
      point.highest = std::max(point.highest, error);
      point.mean += std::log(error) / static_cast<double>(usable_courses.size());
    }
    point.mean = std::exp(point.mean);
    band.push_back(point);
  }
  return band;
}

std::optional<double> mean_slope(const Courses& courses) {
  double sum = 0, count = 0;
  for (const auto& course : courses)
    if (const auto law = fit_power_law(course); law && law->is_fitted) {
      sum += law->slope;
      ++count;
    }
  if (count > 0) return sum / count;
  return {};
}

std::optional<double> last_error(const Courses& courses) {
  double log_sum = 0, count = 0;
  for (const auto& course : courses)
    if (const auto points = usable(course); !points.empty()) {
      log_sum += std::log(points.back().error);
      ++count;
    }
  if (count > 0) return std::exp(log_sum / count);
  return {};
}

}  // namespace gmis::tools
