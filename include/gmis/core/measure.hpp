#pragma once

#include <limits>

#include "gmis/core/math.hpp"

/// \file
/// Densities with their measure in the type, and the one place where one becomes the other.

namespace gmis {

/// Probability density per steradian.
template <std::floating_point T>
struct SolidAnglePdf {
  T value{};
};

/// Probability density per unit area of the surface it is taken on.
template <std::floating_point T>
struct AreaPdf {
  T value{};
};

/// Both densities of one scattering event: of `to_next` given `to_prev` (forward), and of `to_prev` given `to_next`
/// (reverse, what a subpath coming from the other end would use).
template <std::floating_point T>
struct DirectionPdfs {
  SolidAnglePdf<T> forward, reverse;
};

/// d(solid angle)/d(area) for a point seen at `distance_squared` under `cos_at_point` between its normal and the ray.
template <std::floating_point T>
[[nodiscard]] constexpr T solid_angle_per_area(T cos_at_point, T distance_squared) noexcept {
  return (cos_at_point < T(0) ? -cos_at_point : cos_at_point) / distance_squared;
}

template <std::floating_point T>
[[nodiscard]] constexpr AreaPdf<T> to_area(SolidAnglePdf<T> pdf, T cos_at_point, T distance_squared) noexcept {
  return {pdf.value * solid_angle_per_area(cos_at_point, distance_squared)};
}

/// A density that a weight can be formed with: positive and finite. Anything else belongs to a sample that should not exist.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_usable_density(T density) noexcept {
  return density > T(0) && density <= std::numeric_limits<T>::max();
}

}  // namespace gmis
