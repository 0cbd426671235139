#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

#include "gmis/core/attributes.hpp"

namespace gmis {

/// A non-negative number with the precision of `T` and practically no bound on its exponent, in 8
/// bytes for float.
///
/// The recursive weights of a path are products of up to 256 ratios of densities, each ratio
/// anywhere in 1e±40: they leave the range of double after 8 vertices, and clamping is wrong
/// because later factors bring the value back. The value here is mantissa · (2^64)^exponent (float)
/// or mantissa · (2^512)^exponent (double), with the mantissa kept in the middle half of its range,
/// so that one product never overflows or becomes denormal. In ordinary scenes the exponent stays 0
/// and the branches that renormalise are never taken.
///
/// Zero is represented; negative, infinite and NaN inputs are outside the contract (they propagate
/// as T would do).
template <std::floating_point T>
class Extended {
  static_assert(std::numeric_limits<T>::is_iec559);
  static constexpr bool is_single = std::numeric_limits<T>::max_exponent <= 128;

 public:
  /// Bound that mantissas stay below.
  static constexpr T upper = is_single ? T(0x1p32) : T(0x1p256);
  /// Least mantissa that is not 0.
  static constexpr T lower = is_single ? T(0x1p-32) : T(0x1p-256);
  /// The factor that one step of the exponent stands for.
  static constexpr T step = upper * upper;
  /// 1 / `step`.
  static constexpr T inverse_step = lower * lower;

  constexpr Extended() = default;
  // Implicit on purpose, so that densities enter the recursion without a conversion.
  /// The number `value`, exactly.
  constexpr Extended(T value) noexcept : mantissa_(value) {  // NOLINT(google-explicit-constructor)
    normalize();
    normalize();  // twice, because the ends of T's range are two steps away from the middle
  }

  [[nodiscard]] friend constexpr Extended operator*(Extended a, Extended b) noexcept {
    Extended product(a.mantissa_ * b.mantissa_, a.exponent_ + b.exponent_);
    product.normalize();
    return product;
  }

  [[nodiscard]] friend constexpr Extended operator/(Extended a, Extended b) noexcept {
    Extended quotient(a.mantissa_ / b.mantissa_, a.exponent_ - b.exponent_);
    quotient.normalize();
    return quotient;
  }

  [[nodiscard]] friend constexpr Extended operator+(Extended a, Extended b) noexcept {
    if (a.exponent_ != b.exponent_) [[unlikely]]
      return add_unequal(a, b);
    Extended sum(a.mantissa_ + b.mantissa_, a.exponent_);
    sum.normalize();
    return sum;
  }

  /// True for 0.
  [[nodiscard]] constexpr bool is_zero() const noexcept { return mantissa_ == T(0); }
  /// True when the value is `mantissa()`: 0, or from `lower` to `upper`.
  [[nodiscard]] constexpr bool has_no_exponent() const noexcept { return exponent_ == 0; }
  /// The value without its exponent.
  [[nodiscard]] constexpr T mantissa() const noexcept { return mantissa_; }

  /// How many steps the mantissa is multiplied by.
  [[nodiscard]] constexpr std::int32_t exponent() const noexcept { return exponent_; }
  /// The number with this mantissa and exponent, which must come from an `Extended` number.
  [[nodiscard]] static constexpr Extended of(T mantissa, std::int32_t exponent) noexcept {
    return Extended(mantissa, exponent);
  }

  /// A finite double, rounded to the precision of `T`.
  [[nodiscard]] static constexpr Extended rounded(double value) noexcept {
    const T mantissa = static_cast<T>(value);
    if ((mantissa >= lower && mantissa < upper) || value == 0.0) [[likely]]
      return Extended(mantissa, 0);
    return rounded_from_afar(value);
  }

  /// The nearest double, for printing: 0 on underflow, infinity on overflow.
  [[nodiscard]] double to_double() const noexcept {
    return std::ldexp(static_cast<double>(mantissa_), exponent_ * (is_single ? 64 : 512));
  }

  /// The nearest `T`: 0 on underflow, infinity on overflow.
  [[nodiscard]] constexpr T value() const noexcept {
    if (exponent_ == 0) [[likely]]
      return mantissa_;
    T result = mantissa_;
    if (exponent_ > 3) return mantissa_ == T(0) ? T(0) : std::numeric_limits<T>::infinity();
    if (exponent_ < -4) return T(0);
    for (std::int32_t e = exponent_; e > 0; --e) result *= step;
    for (std::int32_t e = exponent_; e < 0; ++e) result *= inverse_step;
    return result;
  }

 private:
  constexpr Extended(T mantissa, std::int32_t exponent) noexcept : mantissa_(mantissa), exponent_(exponent) {}

  [[nodiscard]] GMIS_NEVER_INLINE static constexpr Extended rounded_from_afar(double value) noexcept {
    std::int32_t exponent = 0;
    for (; value >= static_cast<double>(upper) && value <= std::numeric_limits<double>::max(); ++exponent)
      value *= static_cast<double>(inverse_step);
    for (; value < static_cast<double>(lower) && value > 0.0; --exponent) value *= static_cast<double>(step);
    Extended result(static_cast<T>(value), exponent);
    result.normalize();  // rounding may have reached `upper`
    return result;
  }

  constexpr void normalize() noexcept {
    if (mantissa_ >= upper) [[unlikely]] {
      mantissa_ *= inverse_step;
      ++exponent_;
    } else if (mantissa_ < lower) [[unlikely]] {
      if (mantissa_ == T(0)) {
        exponent_ = 0;
      } else {
        mantissa_ *= step;
        --exponent_;
      }
    }
  }

  [[nodiscard]] static constexpr Extended add_unequal(Extended a, Extended b) noexcept {
    if (a.is_zero()) return b;
    if (b.is_zero()) return a;
    const Extended large = a.exponent_ > b.exponent_ ? a : b;
    const Extended small = a.exponent_ > b.exponent_ ? b : a;
    if (large.exponent_ - small.exponent_ > 1) return large;  // at least one whole step apart: below half an ulp
    Extended sum(large.mantissa_ + small.mantissa_ * inverse_step, large.exponent_);
    sum.normalize();
    return sum;
  }

  T mantissa_{};
  std::int32_t exponent_ = 0;
};

}  // namespace gmis
