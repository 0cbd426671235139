#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/error_fit.hpp"
#include "gmis/result/error_law.hpp"

namespace gmis {

/// The iterations and the time that a run needs, from its beginning, to come down to an error.
struct Price {
  double error = 0.0;         ///< relative error to be reached
  double iterations = 0.0;    ///< infinite, like the times, when the error does not fall that far
  double cpu_seconds = 0.0;   ///< processor time of all threads
  double wall_seconds = 0.0;  ///< with the threads of this run
  bool is_reached = false;    ///< read from the log; otherwise predicted
};

/// Prices of several errors, and the law that the predicted ones follow.
struct PriceTable {
  /// Errors that a table has by default.
  static constexpr std::array<double, 5> usual_errors{0.1, 0.05, 0.02, 0.01, 0.005};

  std::vector<Price> prices;  ///< in the order in which the errors were asked for
  ErrorLaw law;               ///< of the error over iterations

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(prices, law);
  }
};

/// The iterations and the time of a part of a run.
struct WorkDone {
  double iterations = 0.0;    ///< how many
  double cpu_seconds = 0.0;   ///< processor time of all threads
  double wall_seconds = 0.0;  ///< with the threads of this run
};

namespace detail {

/// The points of a log that have an estimate, as errors over iterations.
[[nodiscard]] inline std::vector<ErrorAtTime> course_over_iterations(std::span<const ConvergencePoint> log,
                                                                     std::uint64_t first) {
  std::vector<ErrorAtTime> course;
  for (const ConvergencePoint& point : log)
    if (point.estimated_error && point.iteration >= first)
      course.push_back({static_cast<double>(point.iteration), *point.estimated_error});
  return course;
}

/// A time at an iteration count: on the line between the two points around it, and beyond the last
/// point on the line through that and the latest one of at most half its iterations, since the
/// beginning of a run is not typical of the rest.
[[nodiscard]] inline double time_at(std::span<const ConvergencePoint> log, double iterations,
                                    double ConvergencePoint::*time) {
  const auto count_at = [&](std::size_t i) { return static_cast<double>(log[i].iteration); };
  std::size_t after = 0;
  while (after < log.size() && count_at(after) < iterations) ++after;
  if (after == 0) return log[0].*time * iterations / count_at(0);
  std::size_t before = after - 1;
  if (after == log.size()) {
    after = log.size() - 1;
    before = after;
    while (before > 0 && 2.0 * count_at(before) > count_at(after)) --before;
  }
  if (before == after) return log[after].*time * iterations / count_at(after);
  const double rate = (log[after].*time - log[before].*time) / (count_at(after) - count_at(before));
  return log[after].*time + rate * (iterations - count_at(after));
}

}  // namespace detail

/// The prices of errors before a run, by the law that a choice of counts forecasts
/// (`expected_law`). `begun`: what the run has taken so far, pilot included. `later`: what a later
/// part takes, with iterations like those to come. An error that is reached within the iterations
/// of `begun` costs its share of their time.
GMIS_RARE [[nodiscard]] inline PriceTable forecast_prices(const ErrorLaw& law, const WorkDone& begun,
                                                          const WorkDone& later,
                                                          std::span<const double> errors = PriceTable::usual_errors) {
  PriceTable table{{}, law};
  for (const double error : errors) {
    const double iterations = std::max(1.0, std::ceil(law.iterations_to_reach(error)));
    const double share = std::min(1.0, iterations / begun.iterations);
    const double more = std::max(0.0, iterations - begun.iterations) / later.iterations;
    table.prices.push_back({error, iterations, share * begun.cpu_seconds + more * later.cpu_seconds,
                            share * begun.wall_seconds + more * later.wall_seconds, false});
  }
  return table;
}

/// The prices of errors from the log of a run. An error that the log came down to for good is
/// reached: its price is read between two points. The others are predicted by the law fitted to
/// errors over *iterations*: other programs on the machine change the times. `expected`: the law as
/// far as it was known before the run; α = 1 says that nothing merges. Points before iteration 8
/// say too little about themselves to take part. Nothing without a point from there on with an
/// error above 0.
GMIS_RARE [[nodiscard]] inline std::optional<PriceTable> price_table(
    std::span<const ConvergencePoint> log, std::span<const double> errors = PriceTable::usual_errors,
    const ErrorLaw& expected = {}) {
  constexpr std::uint64_t first = 8;
  const std::vector<ErrorAtTime> course = detail::course_over_iterations(log, first);
  if (course.empty() || !(course.back().error > 0.0)) return {};
  PriceTable table{{}, fit_error_law(course, expected, !log.back().interval)};
  for (const double error : errors) {
    const std::optional<double> reached = seconds_until(course, error);
    // An error that is not reached lies ahead, wherever the law passes the last point.
    const double iterations =
        reached ? *reached : std::max(course.back().seconds, table.law.iterations_to_reach(error));
    Price price{error, std::ceil(iterations), 0.0, 0.0, reached.has_value()};
    if (std::isfinite(price.iterations)) {
      price.cpu_seconds = detail::time_at(log, price.iterations, &ConvergencePoint::cpu_seconds);
      price.wall_seconds = detail::time_at(log, price.iterations, &ConvergencePoint::wall_seconds);
    } else {
      price.cpu_seconds = price.wall_seconds = std::numeric_limits<double>::infinity();
    }
    table.prices.push_back(price);
  }
  return table;
}

}  // namespace gmis
