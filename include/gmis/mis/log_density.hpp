#pragma once

#include <cmath>
#include <concepts>
#include <limits>

namespace gmis {

/// A density given by its natural logarithm, for values outside the range of T.
template <std::floating_point T>
struct LogDensity {
  T log;
};

/// log Σ c_i exp(l_i), term by term and without storing them: the sum is kept relative to the largest term so far.
template <std::floating_point T>
class LogSum {
 public:
  /// Adds exp(log_term).
  void add(T log_term) noexcept {
    if (log_term <= largest_) {
      if (log_term != -infinity) sum_ += std::exp(log_term - largest_);
    } else if (log_term == infinity) {
      largest_ = infinity;
      sum_ = T(1);
    } else {  // the new largest term, or NaN, which is passed on
      sum_ = sum_ * std::exp(largest_ - log_term) + T(1);
      largest_ = log_term;
    }
  }

  /// −infinity for an empty sum, NaN when a term was NaN.
  [[nodiscard]] T log() const noexcept { return sum_ > T(0) ? largest_ + std::log(sum_) : largest_ + sum_; }

 private:
  static constexpr T infinity = std::numeric_limits<T>::infinity();
  T largest_ = -infinity;
  T sum_ = T(0);
};

}  // namespace gmis
