#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "gmis/core/ieee.hpp"
#include "gmis/core/math.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace gmis {

/// Three coordinates and an unused fourth number, which fills a register.
template <class T>
using AxisArray = std::array<T, 4>;

/// The three coordinates of a vector worked on at once: a plain loop, and a register for `float`
/// where the compiler may use SSE2, with the same bits.
template <std::floating_point T>
struct AxisLanes {
  Vec3<T> value;  ///< x, y and z

  /// The coordinates of `v`.
  [[nodiscard]] static AxisLanes of(const Vec3<T>& v) noexcept { return {v}; }
  /// All three coordinates are `x`.
  [[nodiscard]] static AxisLanes all(T x) noexcept { return {Vec3<T>(x)}; }
  /// Writes the coordinates to the first three numbers of `to`.
  void store(AxisArray<T>& to) const noexcept { to = {value.x, value.y, value.z, T(0)}; }

  [[nodiscard]] friend AxisLanes operator+(const AxisLanes& a, const AxisLanes& b) noexcept {
    return {a.value + b.value};
  }
  [[nodiscard]] friend AxisLanes operator-(const AxisLanes& a, const AxisLanes& b) noexcept {
    return {a.value - b.value};
  }
  [[nodiscard]] friend AxisLanes operator*(const AxisLanes& a, const AxisLanes& b) noexcept {
    return {a.value * b.value};
  }
  /// True when every coordinate of `a` and of `b` is at most `bound`; false where a coordinate of
  /// both is not a number.
  [[nodiscard]] friend bool are_at_most(const AxisLanes& a, const AxisLanes& b, T bound) noexcept {
    const auto is_below = [&](const Vec3<T>& v) { return v.x <= bound && v.y <= bound && v.z <= bound; };
    return is_below(a.value) && is_below(b.value);
  }
  /// The largest integers that are not above the coordinates, which must be within the range of the
  /// integers.
  [[nodiscard]] AxisArray<std::int32_t> floors() const noexcept {
    const auto floor = [](T x) { return static_cast<std::int32_t>(std::floor(x)); };
    return {floor(value.x), floor(value.y), floor(value.z), 0};
  }
  /// 1 / x; ±∞ of ±0.
  [[nodiscard]] AxisLanes inverse() const noexcept {
    return {{ieee_divide(T(1), value.x), ieee_divide(T(1), value.y), ieee_divide(T(1), value.z)}};
  }
  /// Bit i is set where coordinate i has its sign set: below 0, or −0.
  [[nodiscard]] std::uint32_t signs() const noexcept {
    return (std::signbit(value.x) ? 1U : 0U) | (std::signbit(value.y) ? 2U : 0U) | (std::signbit(value.z) ? 4U : 0U);
  }
  /// Bit i is set where coordinate i is longer than the next one; after the last comes the first.
  [[nodiscard]] std::uint32_t descents() const noexcept {
    const T x = std::abs(value.x), y = std::abs(value.y), z = std::abs(value.z);
    return (x > y ? 1U : 0U) | (y > z ? 2U : 0U) | (z > x ? 4U : 0U);
  }
};

#if defined(__SSE2__)
/// The three coordinates in one register of SSE2.
template <>
struct AxisLanes<float> {
  __m128 value;  ///< x, y, z, and a fourth number that equals the third

  /// The coordinates of `v`.
  [[nodiscard]] static AxisLanes of(const Vec3<float>& v) noexcept { return {_mm_setr_ps(v.x, v.y, v.z, v.z)}; }
  /// All three coordinates are `x`.
  [[nodiscard]] static AxisLanes all(float x) noexcept { return {_mm_set1_ps(x)}; }
  /// Writes the coordinates to the first three numbers of `to`.
  void store(AxisArray<float>& to) const noexcept { _mm_storeu_ps(to.data(), value); }

  [[nodiscard]] friend AxisLanes operator+(AxisLanes a, AxisLanes b) noexcept { return {_mm_add_ps(a.value, b.value)}; }
  [[nodiscard]] friend AxisLanes operator-(AxisLanes a, AxisLanes b) noexcept { return {_mm_sub_ps(a.value, b.value)}; }
  [[nodiscard]] friend AxisLanes operator*(AxisLanes a, AxisLanes b) noexcept { return {_mm_mul_ps(a.value, b.value)}; }
  [[nodiscard]] friend bool are_at_most(AxisLanes a, AxisLanes b, float bound) noexcept {
    return _mm_movemask_ps(_mm_cmple_ps(_mm_max_ps(a.value, b.value), _mm_set1_ps(bound))) == 15;
  }
  /// The largest integers that are not above the coordinates, which must be within their range.
  [[nodiscard]] AxisArray<std::int32_t> floors() const noexcept {
    const __m128i towards_zero = _mm_cvttps_epi32(value);
    const __m128i is_above = _mm_castps_si128(_mm_cmplt_ps(value, _mm_cvtepi32_ps(towards_zero)));  // −1 or 0
    alignas(16) AxisArray<std::int32_t> result;
    _mm_store_si128(reinterpret_cast<__m128i*>(result.data()), _mm_add_epi32(towards_zero, is_above));
    return result;
  }
  /// 1 / x; ±∞ of ±0.
  [[nodiscard]] AxisLanes inverse() const noexcept { return {_mm_div_ps(_mm_set1_ps(1.0F), value)}; }
  /// Bit i is set where coordinate i has its sign set: below 0, or −0.
  [[nodiscard]] std::uint32_t signs() const noexcept { return static_cast<std::uint32_t>(_mm_movemask_ps(value)) & 7U; }
  /// Bit i is set where coordinate i is longer than the next one; after the last comes the first.
  [[nodiscard]] std::uint32_t descents() const noexcept {
    const __m128 lengths = _mm_andnot_ps(_mm_set1_ps(-0.0F), value);
    const __m128 next = _mm_shuffle_ps(lengths, lengths, _MM_SHUFFLE(3, 0, 2, 1));
    return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_cmpgt_ps(lengths, next)));
  }
};
#endif

}  // namespace gmis
