#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "gmis/core/math.hpp"
#include "gmis/scene/bvh_build.hpp"

namespace gmis::scene {

/// Twice the area along the normal.
template <std::floating_point T>
[[nodiscard]] glm::dvec3 area_normal(const TriangleCorners<T>& c) {
  return glm::cross(glm::dvec3(c[1]) - glm::dvec3(c[0]), glm::dvec3(c[2]) - glm::dvec3(c[0]));
}

/// Bounds how far along the normal (unit) a hit, or a point drawn, is from the triangle that rays
/// are tested against: the rounding of the point, of its offset, and of the test of a ray that
/// starts near the triangle. In scene units; `SurfacePoint::position_error`.
template <std::floating_point T>
[[nodiscard]] T position_error(const TriangleCorners<T>& corners, const glm::dvec3& normal) {
  double across = 0, extent = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double lower = static_cast<double>(corners[0][axis]), upper = lower, largest = 0;
    for (const Vec3<T>& corner : corners) {
      lower = std::min(lower, static_cast<double>(corner[axis]));
      upper = std::max(upper, static_cast<double>(corner[axis]));
      largest = std::max(largest, std::abs(static_cast<double>(corner[axis])));
    }
    across += std::abs(normal[axis]) * largest;
    extent += upper - lower;
  }
  return static_cast<T>((6 * across + 10 * extent) * static_cast<double>(std::numeric_limits<T>::epsilon()));
}
/// A bound on the rounding error of a point on a sphere, in scene units: from the size of the
/// centre's coordinates and from the radius.
template <std::floating_point T>
[[nodiscard]] T position_error(const SphereShape<T>& ball) {
  const double size = std::abs(static_cast<double>(ball.center.x)) + std::abs(static_cast<double>(ball.center.y)) +
                      std::abs(static_cast<double>(ball.center.z));
  return static_cast<T>((4 * size + 16 * static_cast<double>(ball.radius)) *
                        static_cast<double>(std::numeric_limits<T>::epsilon()));
}

}  // namespace gmis::scene
