#pragma once

namespace gmis {

/// A running sum whose rounding error does not grow with the number of terms: the sum is kept in two `T`, renormalised after
/// every term, so it is as good as one in twice the precision (error about n ε² Σ|terms|) [Dekker 1971; Knuth's two-sum].
///
/// `T` is a floating-point type. A sum that was ever infinite or NaN reads as the plain sum does.
template <class T>
class CompensatedSum {
 public:
  constexpr CompensatedSum() = default;
  constexpr explicit CompensatedSum(T start) : sum_(start) {}

  constexpr void add(T term) noexcept {
    const T next = sum_ + term;
    const T term_part = next - sum_;
    const T lost = (sum_ - (next - term_part)) + (term - term_part);
    const T tail = correction_ + lost;
    sum_ = next + tail;
    correction_ = tail - (sum_ - next);
    if (sum_ != sum_ && next == next) sum_ = next;  // inf − inf in the correction must not hide an infinite sum
    if (correction_ != correction_) correction_ = T(0);
  }

  constexpr CompensatedSum& operator+=(T term) noexcept {
    add(term);
    return *this;
  }

  constexpr CompensatedSum& operator+=(const CompensatedSum& other) noexcept {
    add(other.sum_);
    add(other.correction_);
    return *this;
  }

  [[nodiscard]] constexpr T value() const noexcept { return sum_ + correction_; }

 private:
  T sum_{};
  T correction_{};
};

}  // namespace gmis
