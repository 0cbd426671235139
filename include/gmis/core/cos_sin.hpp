#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <numbers>
#include <type_traits>

#include "gmis/core/attributes.hpp"

/// \file
/// Cosine and sine of the angles that sampling draws; for `float`, short polynomials without a call
/// and without a branch.

namespace gmis {

/// The cosine and the sine of one angle.
template <std::floating_point T>
struct CosSin {
  T cos;  ///< cosine of the angle
  T sin;  ///< sine of the angle
};

namespace detail {

/// (b, a) when `swapped`, else (a, b). In integers, because a choice between floats would be a
/// branch.
template <std::floating_point T>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr CosSin<T> swapped_if(bool swapped, T a, T b) noexcept {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  const Bits difference =
      (std::bit_cast<Bits>(a) ^ std::bit_cast<Bits>(b)) & (Bits{0} - static_cast<Bits>(swapped ? 1 : 0));
  return {std::bit_cast<T>(static_cast<Bits>(std::bit_cast<Bits>(a) ^ difference)),
          std::bit_cast<T>(static_cast<Bits>(std::bit_cast<Bits>(b) ^ difference))};
}

/// −x when `negated`, else x. In integers, too.
template <std::floating_point T>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr T negated_if(bool negated, T x) noexcept {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  return std::bit_cast<T>(
      static_cast<Bits>(std::bit_cast<Bits>(x) ^ static_cast<Bits>(negated ? 1 : 0) << (8 * sizeof(T) - 1)));
}

}  // namespace detail

/// Cosine and sine of π/4 · `t`, −1 ≤ t ≤ 1. For `float` the minimax polynomials in t² of sin(π/4
/// t)/t (error 2.4e-9) and of cos(π/4 t) (4.7e-11), so that what is left is the rounding: within
/// 2.4e-7.
template <std::floating_point T>
[[nodiscard]] inline CosSin<T> cos_sin_of_eighths(T t) noexcept {
  if constexpr (std::same_as<T, float>) {
    const float u = t * t;
    const float cosine =
        (((3.529811404e-6F * u - 3.259386145e-4F) * u + 0.01585432525F) * u - 0.3084251352F) * u + 1.0F;
    const float sine = ((-3.59545065e-5F * u + 2.490007125e-3F) * u - 0.08074543483F) * u + 0.785398161F;
    return {cosine, sine * t};
  } else {
    const T angle = std::numbers::pi_v<T> / T(4) * t;
    return {std::cos(angle), std::sin(angle)};
  }
}

/// Cosine and sine of 2π · `turns`, 0 ≤ turns ≤ 1.
template <std::floating_point T>
[[nodiscard]] inline CosSin<T> cos_sin_of_turns(T turns) noexcept {
  // From the nearest quarter on; both the product and the difference are exact.
  const T quarters = T(4) * turns;
  const auto quarter = static_cast<std::int32_t>(quarters + T(0.5));
  const CosSin<T> rest = cos_sin_of_eighths(T(2) * (quarters - static_cast<T>(quarter)));
  const auto [x, y] = detail::swapped_if((quarter & 1) != 0, rest.cos, rest.sin);
  return {detail::negated_if(((quarter + 1) & 2) != 0, x), detail::negated_if((quarter & 2) != 0, y)};
}

}  // namespace gmis
