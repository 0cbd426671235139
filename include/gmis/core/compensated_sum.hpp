#pragma once

namespace gmis {

/// A running sum with about twice the precision of `T`. The sum is stored in two `T`, renormalised
/// after every term; the error is about n ε² Σ|terms| for n terms [Dekker 1971; Knuth's two-sum].
///
/// `T` is a floating-point type. After an infinite or NaN term, `value` is infinite or NaN like a
/// plain sum.
template <class T>
class CompensatedSum {
 public:
  constexpr CompensatedSum() = default;
  /// A sum that begins with `start`.
  constexpr explicit CompensatedSum(T start) : sum_(start) {}

  /// Adds a term and keeps the rounding error.
  constexpr void add(T term) noexcept {
    const T next = sum_ + term;
    const T term_part = next - sum_;
    const T lost = (sum_ - (next - term_part)) + (term - term_part);
    const T tail = correction_ + lost;
    sum_ = next + tail;
    correction_ = tail - (sum_ - next);
    if (sum_ != sum_ && next == next) sum_ = next;  // keep an infinite sum: the correction contains inf − inf
    if (correction_ != correction_) correction_ = T(0);
  }

  /// Calls `add`.
  constexpr CompensatedSum& operator+=(T term) noexcept {
    add(term);
    return *this;
  }

  /// Adds another sum with its rounding error.
  constexpr CompensatedSum& operator+=(const CompensatedSum& other) noexcept {
    add(other.sum_);
    add(other.correction_);
    return *this;
  }

  /// The sum, rounded once.
  [[nodiscard]] constexpr T value() const noexcept { return sum_ + correction_; }

 private:
  T sum_{};
  T correction_{};
};

}  // namespace gmis
