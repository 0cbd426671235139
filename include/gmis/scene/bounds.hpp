#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// \file
/// Boxes for building a tree: their corners are four numbers worked on at once, of which the fourth
/// means nothing. In the processor's own registers for `float` where there is SSE2, with the bits
/// of the plain loops.

namespace gmis::scene {

template <std::floating_point T>
struct Quad {
  std::array<T, 4> value;

  [[nodiscard]] static Quad all(T x) noexcept { return {{x, x, x, x}}; }
  [[nodiscard]] static Quad of(T x, T y, T z) noexcept { return {{x, y, z, T(0)}}; }
  [[nodiscard]] T operator[](std::size_t i) const noexcept { return value[i]; }

  [[nodiscard]] friend Quad operator+(const Quad& a, const Quad& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] + b.value[i]; });
  }
  [[nodiscard]] friend Quad operator-(const Quad& a, const Quad& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] - b.value[i]; });
  }
  [[nodiscard]] friend Quad operator*(const Quad& a, const Quad& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] * b.value[i]; });
  }
  /// The smaller and the larger of the two; `b` where either is not a number.
  [[nodiscard]] friend Quad minimum(const Quad& a, const Quad& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] < b.value[i] ? a.value[i] : b.value[i]; });
  }
  [[nodiscard]] friend Quad maximum(const Quad& a, const Quad& b) noexcept {
    return each([&](std::size_t i) { return a.value[i] > b.value[i] ? a.value[i] : b.value[i]; });
  }
  /// Without the digits after the point; each must fit.
  [[nodiscard]] std::array<std::int32_t, 4> truncated() const noexcept {
    return {static_cast<std::int32_t>(value[0]), static_cast<std::int32_t>(value[1]),
            static_cast<std::int32_t>(value[2]), static_cast<std::int32_t>(value[3])};
  }
  /// x y + y z + z x.
  [[nodiscard]] T sum_of_products() const noexcept {
    return value[0] * value[1] + value[1] * value[2] + value[2] * value[0];
  }

 private:
  template <class Operation>
  [[nodiscard]] static Quad each(Operation&& operation) noexcept {
    return {{operation(0), operation(1), operation(2), operation(3)}};
  }
};

#if defined(__SSE2__)
template <>
struct Quad<float> {
  __m128 value;

  [[nodiscard]] static Quad all(float x) noexcept { return {_mm_set1_ps(x)}; }
  [[nodiscard]] static Quad of(float x, float y, float z) noexcept { return {_mm_setr_ps(x, y, z, 0.0F)}; }
  [[nodiscard]] float operator[](std::size_t i) const noexcept {
    alignas(16) std::array<float, 4> stored;
    _mm_store_ps(stored.data(), value);
    return stored[i];
  }

  [[nodiscard]] friend Quad operator+(Quad a, Quad b) noexcept { return {_mm_add_ps(a.value, b.value)}; }
  [[nodiscard]] friend Quad operator-(Quad a, Quad b) noexcept { return {_mm_sub_ps(a.value, b.value)}; }
  [[nodiscard]] friend Quad operator*(Quad a, Quad b) noexcept { return {_mm_mul_ps(a.value, b.value)}; }
  [[nodiscard]] friend Quad minimum(Quad a, Quad b) noexcept { return {_mm_min_ps(a.value, b.value)}; }
  [[nodiscard]] friend Quad maximum(Quad a, Quad b) noexcept { return {_mm_max_ps(a.value, b.value)}; }
  [[nodiscard]] std::array<std::int32_t, 4> truncated() const noexcept {
    alignas(16) std::array<std::int32_t, 4> stored;
    _mm_store_si128(reinterpret_cast<__m128i*>(stored.data()), _mm_cvttps_epi32(value));
    return stored;
  }
  [[nodiscard]] float sum_of_products() const noexcept {
    const __m128 products = _mm_mul_ps(value, _mm_shuffle_ps(value, value, _MM_SHUFFLE(3, 0, 2, 1)));
    const __m128 second = _mm_shuffle_ps(products, products, _MM_SHUFFLE(1, 1, 1, 1));
    const __m128 third = _mm_movehl_ps(products, products);
    return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(products, second), third));
  }
};
#endif

/// An axis-aligned box; empty until something is added.
template <std::floating_point T>
struct Bounds {
  Quad<T> lower = Quad<T>::all(std::numeric_limits<T>::infinity());
  Quad<T> upper = Quad<T>::all(-std::numeric_limits<T>::infinity());

  void add(const Quad<T>& point) noexcept {
    lower = minimum(lower, point);
    upper = maximum(upper, point);
  }
  /// An empty box adds nothing.
  void add(const Bounds& other) noexcept {
    lower = minimum(lower, other.lower);
    upper = maximum(upper, other.upper);
  }
  /// Half the surface area; of an empty box infinity.
  [[nodiscard]] T half_area() const noexcept { return (upper - lower).sum_of_products(); }
};

}  // namespace gmis::scene
