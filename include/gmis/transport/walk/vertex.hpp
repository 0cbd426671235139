#pragma once

#include <cstdint>

#include "gmis/core/concepts.hpp"
#include "gmis/core/ieee.hpp"
#include "gmis/transport/effects/path_class.hpp"
#include "gmis/transport/walk/scatter.hpp"

namespace gmis {

/// A vertex of a light subpath, kept for connecting and merging.
template <Scene Sc, class Recursion>
struct LightVertex {
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  SurfacePoint<T> point;
  typename Sc::Bsdf bsdf;
  Vec3<T> to_prev;
  S throughput;  ///< flux that arrives here, per expected tree; no MIS weight
  typename Recursion::LightPartial weights;
  NominalChildren<T> children;  ///< forward: as a light subpath
  std::int16_t depth;           ///< edges from the light
  HalfPath path{};              ///< the events before it
};

/// The vertex that a camera subpath is at.
template <Scene Sc, class Recursion>
struct CameraVertex {
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  const Hit<T, typename Sc::Bsdf, typename Sc::Light>& hit;  ///< no copy: it lives as long as the vertex is looked at
  Vec3<T> to_prev;
  S throughput;
  typename Recursion::CameraPartial weights;
  NominalChildren<T> children{};  ///< forward: as a camera subpath
  std::int16_t depth;             ///< edges from the camera
  HalfPath path{};                ///< the events before it

  /// x_{k−1}: no other vertex lies between it and the camera.
  [[nodiscard]] bool is_next_to_camera() const noexcept { return depth == 1; }
};

/// Two points that may see each other: the unit vector from `from` to `to` and the factors between them. Of one and
/// the same point it has no direction; `distance_squared` is then 0.
template <std::floating_point T>
struct Link {
  Vec3<T> direction;
  T distance_squared;

  [[nodiscard]] static Link between(const Vec3<T>& from, const Vec3<T>& to) noexcept {
    const Vec3<T> offset = to - from;
    const T distance_squared = glm::dot(offset, offset);
    return {offset * ieee_divide(T(1), std::sqrt(distance_squared)), distance_squared};
  }
  /// Change from solid angle at the other end to area at `point`.
  [[nodiscard]] T to_area(const SurfacePoint<T>& point) const noexcept {
    return solid_angle_per_area(glm::dot(point.geometric_normal, direction), distance_squared);
  }
};

}  // namespace gmis
