#pragma once

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

}  // namespace gmis_test
