#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmis/result/error_estimate.hpp"

namespace gmis {

/// State of a run at one moment.
struct ConvergencePoint {
  double cpu_seconds = 0.0;               ///< processor time of all threads
  double wall_seconds = 0.0;              ///< since the start
  std::uint64_t iteration = 0;            ///< how many were done
  std::optional<double> estimated_error;  ///< `ErrorEstimate::relative_error` of all iterations
  std::optional<Interval> interval;       ///< interval around `estimated_error`; empty when that is not calibrated
  std::optional<double> reference_error;  ///< √relMSE against a reference
};

/// Error over time during a run. The iterations of the points grow geometrically, so that a long
/// run leaves a short log and every decade has about the same number of points.
class ConvergenceLog {
 public:
  /// True when a point is due after this iteration. Points are due after the first and
  /// twice per doubling from 4 on: 4, 6, 8, 12, 16, 24 and so on. All batches of `BatchMeans` are
  /// complete at these iterations. From two or three iterations an estimate of the error says
  /// little, and takes as long as from a long run.
  [[nodiscard]] bool is_due(std::uint64_t iteration) const noexcept { return iteration >= next_; }

  /// Adds a point behind the others.
  void add(ConvergencePoint point) {
    const std::uint64_t step = std::bit_floor(point.iteration) / 2;
    next_ = step < 2 ? 4 : point.iteration / step * step + step;
    points_.push_back(std::move(point));
  }

  /// In the order of time.
  [[nodiscard]] const std::vector<ConvergencePoint>& points() const noexcept { return points_; }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(next_, points_);
  }

 private:
  std::uint64_t next_ = 1;
  std::vector<ConvergencePoint> points_;
};

/// The header line of a log in comma-separated values, without a line end.
[[nodiscard]] inline std::string convergence_csv_header() {
  return "cpu_seconds,wall_seconds,iteration,estimated_error,interval_lower,interval_upper,reference_error";
}

/// The line of one point in comma-separated values, without a line end. An unknown value is an
/// empty field. The decimal separator is a point in every locale.
[[nodiscard]] inline std::string convergence_csv_row(const ConvergencePoint& point) {
  const auto text = [](double value) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
    return std::string(buffer.data(), end.ptr);
  };
  const auto text_or_nothing = [&](const std::optional<double>& value) { return value ? text(*value) : std::string(); };
  return text(point.cpu_seconds) + ',' + text(point.wall_seconds) + ',' + std::to_string(point.iteration) + ',' +
         text_or_nothing(point.estimated_error) + ',' + (point.interval ? text(point.interval->lower) : "") + ',' +
         (point.interval ? text(point.interval->upper) : "") + ',' + text_or_nothing(point.reference_error);
}

}  // namespace gmis
