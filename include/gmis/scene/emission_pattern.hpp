#pragma once

#include "gmis/core/attributes.hpp"
#include "gmis/scene/varying_material.hpp"

namespace gmis::scene {

/// The radiance of an area light that varies over its surface, as a function of the surface point
/// alone.
template <std::floating_point T>
struct EmissionPattern {
  using Handle = typename Texture<T>::Handle;
  Handle radiance;  ///< per steradian and projected area; not negative
  Handle opacity;   ///< of a surface with holes, which emit nothing; null where there are none

  /// The radiance at a point.
  [[nodiscard]] GMIS_RARE Vec3<T> at(const SurfaceCoordinates<T>& at) const noexcept {
    if (opacity && !(detail::hashed(at, 0) < opacity->at(at.uv).x)) return Vec3<T>(0);
    return glm::max(radiance->at(at.uv), Vec3<T>(0));
  }
  /// A bound on the radiance where u and v are between those of the three corners.
  [[nodiscard]] Vec3<T> upper_on(const TriangleCoordinates<T>& uv) const noexcept {
    return glm::max(
        radiance->upper_between(glm::min(glm::min(uv[0], uv[1]), uv[2]), glm::max(glm::max(uv[0], uv[1]), uv[2])),
        Vec3<T>(0));
  }
  /// About the mean over a triangle, holes left out of account: that of 64 points, and no less than
  /// 1/64 of `upper_on`. So whatever shines somewhere has a mean above 0, and a chance of being
  /// sampled.
  [[nodiscard]] Vec3<T> mean_on(const TriangleCoordinates<T>& uv) const noexcept {
    constexpr int rows = 8;
    Vec3<T> sum(0);
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < 2 * i + 1; ++j) {
        // The middles of the 64 like triangles that a triangle can be cut into, row by row.
        const T down = (static_cast<T>(i) + (j % 2 == 0 ? T(2) / T(3) : T(1) / T(3))) / T(rows);
        const T across = (static_cast<T>(j / 2) + (j % 2 == 0 ? T(1) / T(3) : T(2) / T(3))) / T(rows);
        sum += glm::max(radiance->at(uv[0] * (T(1) - down) + uv[1] * (down - across) + uv[2] * across), Vec3<T>(0));
      }
    return glm::max(sum, upper_on(uv)) / T(rows * rows);
  }
};

}  // namespace gmis::scene
