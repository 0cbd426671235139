#pragma once

#include <cmath>
#include <cstddef>

#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"

namespace gmis_test {

/// Comparisons that share one false-alarm rate, by Šidák's rule. It counts them: more than were
/// declared would raise false alarms more often than stated.
class Family {
 public:
  Family(double false_alarms, std::size_t size) : level_(gmis::sidak_level(false_alarms, size)), size_(size) {}

  /// The level of the next comparison.
  [[nodiscard]] double level() {
    CHECK(++made_ <= size_);
    return level_;
  }
  /// The largest difference, in standard errors, that the next comparison allows a mean whose
  /// standard error comes from `count` independent values.
  [[nodiscard]] double limit(std::size_t count) {
    return gmis::student_t_quantile(1 - level() / 2, static_cast<double>(count) - 1);
  }
  /// Whether as many comparisons were made as declared: what a test asks that makes all of them.
  [[nodiscard]] bool is_complete() const { return made_ == size_; }
  [[nodiscard]] std::size_t made() const { return made_; }

 private:
  double level_;
  std::size_t size_, made_ = 0;
};

/// Values of independent runs.
class OverRuns {
 public:
  void add(double value) {
    ++count_;
    const double before = value - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before * (value - mean_);
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] double standard_error() const {
    const auto n = static_cast<double>(count_);
    return std::sqrt(squares_ / (n * (n - 1)));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

}  // namespace gmis_test
