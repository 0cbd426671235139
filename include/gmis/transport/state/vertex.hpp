#pragma once

#include <cstdint>

#include "gmis/core/concepts.hpp"
#include "gmis/core/ieee.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/scatter.hpp"

namespace gmis {

/// The current vertex of a light subpath. All directions point away from the surface.
template <Scene Sc, class Recursion>
struct LightVertex {
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  SurfacePoint<T> point;   ///< position and normals of the surface here
  typename Sc::Bsdf bsdf;  ///< scatters light at `point`
  Vec3<T> to_prev;         ///< unit direction to the vertex before, towards the light
  S throughput;            ///< flux that arrives here, divided by the actual density per light tree; without MIS weight
  /// Partial sums of the path weights here.
  typename Recursion::LightPartial weights;
  NominalChildren<T> children;  ///< c here: `forward` of a light subpath, `reverse` of a camera subpath
  std::int16_t depth;           ///< edges from the light
  bool is_photon;               ///< merging gathers it: s(x_{i−1}) = 1 (docs/weights.md)
  std::uint16_t light_group;    ///< of the light that the subpath starts from
  HalfPath path{};              ///< the events before this vertex
};

/// The current vertex of a camera subpath.
template <Scene Sc, class Recursion>
struct CameraVertex {
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  const Hit<T, typename Sc::Bsdf, typename Sc::Light>& hit;  ///< must outlive the vertex
  Vec3<T> to_prev;  ///< unit direction to the vertex before, towards the camera
  S throughput;     ///< factor on the radiance that leaves here along `to_prev`; without MIS weight
  /// Partial sums of the path weights here.
  typename Recursion::CameraPartial weights;
  NominalChildren<T> children{};  ///< c here: `forward` of a camera subpath, `reverse` of a light subpath
  std::int16_t depth;             ///< edges from the camera
  HalfPath path{};                ///< the events between the camera and this vertex

  /// True for x_{k−1}: no other vertex lies between this vertex and the camera.
  [[nodiscard]] constexpr bool is_next_to_camera() const noexcept { return depth == 1; }
};

/// The straight line between two points: the unit vector from `from` to `to` and the factors of
/// measure along it. When both points coincide, `distance_squared` is 0 and `direction` is not
/// finite.
template <std::floating_point T>
struct Link {
  Vec3<T> direction;   ///< unit vector from `from` to `to`
  T distance_squared;  ///< d², in squared scene units

  /// The line from `from` to `to`.
  [[nodiscard]] static constexpr Link between(const Vec3<T>& from, const Vec3<T>& to) noexcept {
    return along(to - from);
  }
  /// The line to a point from another, of which it is `offset` away.
  [[nodiscard]] static constexpr Link along(const Vec3<T>& offset) noexcept {
    const T distance_squared = glm::dot(offset, offset);
    return {offset * ieee_divide(T(1), std::sqrt(distance_squared)), distance_squared};
  }
  /// g at `point` = |cos θ| / d²: the factor from a density per steradian at the other end to a
  /// density per area at `point`, with the geometric normal.
  [[nodiscard]] constexpr T to_area(const SurfacePoint<T>& point) const noexcept {
    return solid_angle_per_area(glm::dot(point.geometric_normal, direction), distance_squared);
  }
};

}  // namespace gmis
