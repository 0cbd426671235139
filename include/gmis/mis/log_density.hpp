#pragma once

#include <cmath>
#include <concepts>
#include <limits>

namespace gmis {

/// A density given by its natural logarithm, for values outside the range of T.
template <std::floating_point T>
struct LogDensity {
  T log;  ///< natural logarithm; −infinity for 0
};

/// log Σ c_i exp(l_i), term by term and without storing them: the sum is kept relative to a term
/// that no other exceeds by more than e^16, so that terms in rising order do not round the whole
/// sum again and again.
template <std::floating_point T>
class LogSum {
 public:
  /// Adds coefficient · exp(log_term), coefficient > 0.
  void add(T log_term, T coefficient = T(1)) noexcept {
    if (log_term <= reference_ + margin) {
      if (log_term != -infinity) sum_ += coefficient * std::exp(log_term - reference_);
    } else if (log_term == infinity) {
      reference_ = infinity;
      sum_ = T(1);
    } else {  // far above all others, or NaN, which is passed on
      sum_ = sum_ * std::exp(reference_ - log_term) + coefficient;
      reference_ = log_term;
    }
  }

  /// The logarithm of the sum over `normaliser`, rounded once where it is large. −infinity for an
  /// empty sum, NaN when a term was NaN.
  [[nodiscard]] T log_over(T normaliser) const noexcept {
    return sum_ > T(0) ? reference_ + std::log(sum_ / normaliser) : reference_ + sum_;
  }
  /// The natural logarithm of the sum.
  [[nodiscard]] T log() const noexcept { return log_over(T(1)); }

 private:
  static constexpr T infinity = std::numeric_limits<T>::infinity();
  static constexpr T margin = T(16);
  T reference_ = -infinity;
  T sum_ = T(0);
};

}  // namespace gmis
