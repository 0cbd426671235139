#pragma once

#include <limits>

#include "gmis/core/math.hpp"

/// \file
/// Densities with their measure in the type, and the factor between solid angle and area.

namespace gmis {

/// Probability density per steradian.
template <std::floating_point T>
struct SolidAnglePdf {
  T value{};  ///< the density
};

/// Both densities of one scattering event, per steradian without the cosine: `forward` of `to_next`
/// given `to_prev`, `reverse` of `to_prev` given `to_next` (for a subpath from the other end of the
/// path).
template <std::floating_point T>
struct DirectionPdfs {
  SolidAnglePdf<T> forward;  ///< of `to_next` given `to_prev`
  SolidAnglePdf<T> reverse;  ///< of `to_prev` given `to_next`
};

/// d(solid angle)/d(area) = |cos θ| / d² of a point at the squared distance d², with θ between its
/// normal and the ray.
template <std::floating_point T>
[[nodiscard]] constexpr T solid_angle_per_area(T cos_at_point, T distance_squared) noexcept {
  return (cos_at_point < T(0) ? -cos_at_point : cos_at_point) / distance_squared;
}

/// True for a density from which a weight can be formed: positive and finite.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_usable_density(T density) noexcept {
  return density > T(0) && density <= std::numeric_limits<T>::max();
}

}  // namespace gmis
