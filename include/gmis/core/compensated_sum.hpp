#pragma once

#include <cmath>

namespace gmis {

/// A running sum whose rounding error does not grow with the number of terms (Neumaier 1974).
///
/// `T` is a floating-point type. A sum that was ever infinite or NaN reads as the plain sum does.
template <class T>
class CompensatedSum {
 public:
  constexpr CompensatedSum() = default;
  constexpr explicit CompensatedSum(T start) : sum_(start) {}

  constexpr void add(T term) noexcept {
    const T next = sum_ + term;
    const bool sum_is_larger = (sum_ < T(0) ? -sum_ : sum_) >= (term < T(0) ? -term : term);
    // The larger operand loses nothing; what the smaller one lost is what the rounded sum does not account for.
    correction_ += sum_is_larger ? (sum_ - next) + term : (term - next) + sum_;
    sum_ = next;
  }

  constexpr CompensatedSum& operator+=(T term) noexcept {
    add(term);
    return *this;
  }

  constexpr CompensatedSum& operator+=(const CompensatedSum& other) noexcept {
    add(other.sum_);
    correction_ += other.correction_;
    return *this;
  }

  [[nodiscard]] constexpr T value() const noexcept {
    const T corrected = sum_ + correction_;
    return corrected == corrected ? corrected : sum_;  // inf − inf in the correction must not hide an infinite sum
  }

 private:
  T sum_{};
  T correction_{};
};

}  // namespace gmis
