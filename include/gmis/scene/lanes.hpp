#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>

#include "gmis/core/ieee.hpp"

#if defined(__AVX2__) && defined(__FMA__)
#define GMIS_LANES_AVX2
#include <immintrin.h>
#elif defined(__SSE2__)
#define GMIS_LANES_SSE2
#include <emmintrin.h>
#endif

/// \file
/// Eight numbers worked on at once: eight boxes or eight primitives against one ray. Plain loops
/// everywhere, and the processor's own registers for `float` where the compiler may use AVX2 or
/// SSE2. SSE2 gives the bits of the plain loops, AVX2 rounds a product and a sum at once.

namespace gmis::scene {

inline constexpr int lane_count = 8;

/// One bit per lane, lane 0 the lowest.
using LaneMask = std::uint32_t;

template <std::floating_point T>
using LaneArray = std::array<T, lane_count>;

/// a·b − c·d with a relative error of 2 units in the last place, whatever cancels: the sign is
/// always right, and the result is 0 only when the exact one is (barring underflow) [Jeannerod,
/// Louvet, Muller 2013].
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

  [[nodiscard]] static Lanes load(const T* from) noexcept {
    return each([&](std::size_t i) { return from[i]; });
  }
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

#if defined(GMIS_LANES_AVX2)
template <>
struct Lanes<float> {
  __m256 value;

  [[nodiscard]] static Lanes load(const float* from) noexcept { return {_mm256_load_ps(from)}; }
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
#elif defined(GMIS_LANES_SSE2)
template <>
struct Lanes<float> {
  __m128 low, high;

  [[nodiscard]] static Lanes load(const float* from) noexcept { return {_mm_load_ps(from), _mm_load_ps(from + 4)}; }
  [[nodiscard]] static Lanes all(float x) noexcept { return {_mm_set1_ps(x), _mm_set1_ps(x)}; }
  void store(LaneArray<float>& to) const noexcept {
    _mm_store_ps(to.data(), low);
    _mm_store_ps(to.data() + 4, high);
  }

  [[nodiscard]] friend Lanes operator+(Lanes a, Lanes b) noexcept {
    return {_mm_add_ps(a.low, b.low), _mm_add_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes operator-(Lanes a, Lanes b) noexcept {
    return {_mm_sub_ps(a.low, b.low), _mm_sub_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes operator*(Lanes a, Lanes b) noexcept {
    return {_mm_mul_ps(a.low, b.low), _mm_mul_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes divide(Lanes a, Lanes b) noexcept {
    return {_mm_div_ps(a.low, b.low), _mm_div_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes multiply_add(Lanes a, Lanes b, Lanes c) noexcept { return a * b + c; }
  [[nodiscard]] friend Lanes subtract_product(Lanes c, Lanes a, Lanes b) noexcept { return c - a * b; }
  [[nodiscard]] friend Lanes product_difference(Lanes a, Lanes b, Lanes c, Lanes d) noexcept {
    return {product_difference(a.low, b.low, c.low, d.low), product_difference(a.high, b.high, c.high, d.high)};
  }
  [[nodiscard]] friend Lanes minimum(Lanes a, Lanes b) noexcept {
    return {_mm_min_ps(a.low, b.low), _mm_min_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes maximum(Lanes a, Lanes b) noexcept {
    return {_mm_max_ps(a.low, b.low), _mm_max_ps(a.high, b.high)};
  }
  [[nodiscard]] friend Lanes root(Lanes a) noexcept {
    const __m128 zero = _mm_setzero_ps();
    return {_mm_sqrt_ps(_mm_max_ps(a.low, zero)), _mm_sqrt_ps(_mm_max_ps(a.high, zero))};
  }
  [[nodiscard]] friend Lanes with_sign_of(Lanes magnitude, Lanes sign) noexcept {
    const __m128 sign_bit = _mm_set1_ps(-0.0F);
    return {choose(sign_bit, sign.low, magnitude.low), choose(sign_bit, sign.high, magnitude.high)};
  }
  [[nodiscard]] friend Lanes positive_or(Lanes a, Lanes b) noexcept {
    const __m128 zero = _mm_setzero_ps();
    return {choose(_mm_cmpgt_ps(a.low, zero), a.low, b.low), choose(_mm_cmpgt_ps(a.high, zero), a.high, b.high)};
  }
  [[nodiscard]] friend LaneMask less(Lanes a, Lanes b) noexcept {
    return mask_of(_mm_cmplt_ps(a.low, b.low), _mm_cmplt_ps(a.high, b.high));
  }
  [[nodiscard]] friend LaneMask less_or_equal(Lanes a, Lanes b) noexcept {
    return mask_of(_mm_cmple_ps(a.low, b.low), _mm_cmple_ps(a.high, b.high));
  }

 private:
  /// The bits of `a` where those of `mask` are set, else those of `b`.
  [[nodiscard]] static __m128 choose(__m128 mask, __m128 a, __m128 b) noexcept {
    return _mm_or_ps(_mm_and_ps(mask, a), _mm_andnot_ps(mask, b));
  }
  [[nodiscard]] static LaneMask mask_of(__m128 low, __m128 high) noexcept {
    return static_cast<LaneMask>(_mm_movemask_ps(low) | (_mm_movemask_ps(high) << 4));
  }
  /// In double, where products of floats are exact.
  [[nodiscard]] static __m128 product_difference(__m128 a, __m128 b, __m128 c, __m128 d) noexcept {
    const auto of_two = [](__m128 e, __m128 f, __m128 g, __m128 h) {
      return _mm_cvtpd_ps(
          _mm_sub_pd(_mm_mul_pd(_mm_cvtps_pd(e), _mm_cvtps_pd(f)), _mm_mul_pd(_mm_cvtps_pd(g), _mm_cvtps_pd(h))));
    };
    const auto upper = [](__m128 x) { return _mm_movehl_ps(x, x); };
    return _mm_movelh_ps(of_two(a, b, c, d), of_two(upper(a), upper(b), upper(c), upper(d)));
  }
};
#endif

}  // namespace gmis::scene
