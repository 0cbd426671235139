#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "gmis/core/ieee.hpp"

#if defined(__AVX2__) && defined(__FMA__)
#include <immintrin.h>
#endif

/// \file
/// Eight numbers worked on at once: eight boxes or eight primitives against one ray. Plain loops everywhere, and the
/// processor's own registers for `float` where the compiler may use AVX2.

namespace gmis::scene {

inline constexpr int lane_count = 8;

/// One bit per lane, lane 0 the lowest.
using LaneMask = std::uint32_t;

template <std::floating_point T>
using LaneArray = std::array<T, lane_count>;

/// a·b − c·d with a relative error of 2 units in the last place, whatever cancels: the sign is always right, and the
/// result is 0 only when the exact one is (barring underflow) [Jeannerod, Louvet, Muller 2013].
template <std::floating_point T>
[[nodiscard]] inline T difference_of_products(T a, T b, T c, T d) noexcept {
  if constexpr (std::same_as<T, float>) {
    // Products of floats are exact in double.
    return static_cast<float>(static_cast<double>(a) * static_cast<double>(b) -
                              static_cast<double>(c) * static_cast<double>(d));
  } else {
    const T cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
  }
}

template <std::floating_point T>
struct Lanes {
  LaneArray<T> value;

  [[nodiscard]] static Lanes load(const LaneArray<T>& from) noexcept { return {from}; }
  [[nodiscard]] static Lanes all(T x) noexcept {
    Lanes result;
    result.value.fill(x);
    return result;
  }
  void store(LaneArray<T>& to) const noexcept { to = value; }

  template <class Operation>
  [[nodiscard]] static Lanes each(Operation&& operation) noexcept {
    Lanes result;
    for (std::size_t i = 0; i < lane_count; ++i) result.value[i] = operation(i);
    return result;
  }
  template <class Predicate>
  [[nodiscard]] static LaneMask mask(Predicate&& predicate) noexcept {
    LaneMask result = 0;
    for (std::size_t i = 0; i < lane_count; ++i) result |= static_cast<LaneMask>(predicate(i)) << i;
    return result;
  }

  [[nodiscard]] friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] + b.value[i]; });
  }
  [[nodiscard]] friend Lanes operator-(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] - b.value[i]; });
  }
  [[nodiscard]] friend Lanes operator*(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] * b.value[i]; });
  }
  [[nodiscard]] friend Lanes divide(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return ieee_divide(a.value[i], b.value[i]); });
  }
  /// a·b + c and c − a·b, rounded once or twice.
  [[nodiscard]] friend Lanes multiply_add(const Lanes& a, const Lanes& b, const Lanes& c) noexcept {
    return each([&](std::size_t i) { return a.value[i] * b.value[i] + c.value[i]; });
  }
  [[nodiscard]] friend Lanes subtract_product(const Lanes& c, const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return c.value[i] - a.value[i] * b.value[i]; });
  }
  [[nodiscard]] friend Lanes product_difference(const Lanes& a, const Lanes& b, const Lanes& c,
                                                const Lanes& d) noexcept {
    return each([&](std::size_t i) { return difference_of_products(a.value[i], b.value[i], c.value[i], d.value[i]); });
  }
  /// The smaller and the larger of the two; `b` where either is not a number.
  [[nodiscard]] friend Lanes minimum(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] < b.value[i] ? a.value[i] : b.value[i]; });
  }
  [[nodiscard]] friend Lanes maximum(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] > b.value[i] ? a.value[i] : b.value[i]; });
  }
  /// √a, and 0 where a is negative.
  [[nodiscard]] friend Lanes root(const Lanes& a) noexcept {
    return each([&](std::size_t i) { return a.value[i] > T(0) ? std::sqrt(a.value[i]) : T(0); });
  }
  [[nodiscard]] friend Lanes with_sign_of(const Lanes& magnitude, const Lanes& sign) noexcept {
    return each([&](std::size_t i) { return std::copysign(magnitude.value[i], sign.value[i]); });
  }
  /// `a` where it is above 0, else `b`.
  [[nodiscard]] friend Lanes positive_or(const Lanes& a, const Lanes& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] > T(0) ? a.value[i] : b.value[i]; });
  }
  [[nodiscard]] friend LaneMask less(const Lanes& a, const Lanes& b) noexcept {
    return mask([&](std::size_t i) { return a.value[i] < b.value[i]; });
  }
  [[nodiscard]] friend LaneMask less_or_equal(const Lanes& a, const Lanes& b) noexcept {
    return mask([&](std::size_t i) { return a.value[i] <= b.value[i]; });
  }
};

#if defined(__AVX2__) && defined(__FMA__)
template <>
struct Lanes<float> {
  __m256 value;

  [[nodiscard]] static Lanes load(const LaneArray<float>& from) noexcept { return {_mm256_load_ps(from.data())}; }
  [[nodiscard]] static Lanes all(float x) noexcept { return {_mm256_set1_ps(x)}; }
  void store(LaneArray<float>& to) const noexcept { _mm256_store_ps(to.data(), value); }

  [[nodiscard]] friend Lanes operator+(Lanes a, Lanes b) noexcept { return {_mm256_add_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes operator-(Lanes a, Lanes b) noexcept { return {_mm256_sub_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes operator*(Lanes a, Lanes b) noexcept { return {_mm256_mul_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes divide(Lanes a, Lanes b) noexcept { return {_mm256_div_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes multiply_add(Lanes a, Lanes b, Lanes c) noexcept {
    return {_mm256_fmadd_ps(a.value, b.value, c.value)};
  }
  [[nodiscard]] friend Lanes subtract_product(Lanes c, Lanes a, Lanes b) noexcept {
    return {_mm256_fnmadd_ps(a.value, b.value, c.value)};
  }
  [[nodiscard]] friend Lanes product_difference(Lanes a, Lanes b, Lanes c, Lanes d) noexcept {
    const __m256 cd = _mm256_mul_ps(c.value, d.value);
    return {_mm256_add_ps(_mm256_fmsub_ps(a.value, b.value, cd), _mm256_fnmadd_ps(c.value, d.value, cd))};
  }
  [[nodiscard]] friend Lanes minimum(Lanes a, Lanes b) noexcept { return {_mm256_min_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes maximum(Lanes a, Lanes b) noexcept { return {_mm256_max_ps(a.value, b.value)}; }
  [[nodiscard]] friend Lanes root(Lanes a) noexcept {
    return {_mm256_sqrt_ps(_mm256_max_ps(a.value, _mm256_setzero_ps()))};
  }
  [[nodiscard]] friend Lanes with_sign_of(Lanes magnitude, Lanes sign) noexcept {
    const __m256 sign_bit = _mm256_set1_ps(-0.0F);
    return {_mm256_or_ps(_mm256_andnot_ps(sign_bit, magnitude.value), _mm256_and_ps(sign_bit, sign.value))};
  }
  [[nodiscard]] friend Lanes positive_or(Lanes a, Lanes b) noexcept {
    return {_mm256_blendv_ps(b.value, a.value, _mm256_cmp_ps(a.value, _mm256_setzero_ps(), _CMP_GT_OQ))};
  }
  [[nodiscard]] friend LaneMask less(Lanes a, Lanes b) noexcept {
    return static_cast<LaneMask>(_mm256_movemask_ps(_mm256_cmp_ps(a.value, b.value, _CMP_LT_OQ)));
  }
  [[nodiscard]] friend LaneMask less_or_equal(Lanes a, Lanes b) noexcept {
    return static_cast<LaneMask>(_mm256_movemask_ps(_mm256_cmp_ps(a.value, b.value, _CMP_LE_OQ)));
  }
};
#endif

}  // namespace gmis::scene
