#pragma once

#include <cmath>
#include <cstddef>

namespace gmis_test {

/// Mean of independent values, with its standard error.
class Series {
 public:
  void add(double value) {
    ++count_;
    const double step = value - mean_;
    mean_ += step / static_cast<double>(count_);
    squares_ += step * (value - mean_);
  }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double standard_error() const {
    const auto n = static_cast<double>(count_);
    return std::sqrt(squares_ / (n * (n - 1.0)));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0, squares_ = 0.0;
};

}  // namespace gmis_test
