#pragma once

#include <cmath>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"

namespace gmis {

/// Replaces `hit` by the next hit along `direction` when `hit` lies on the surface that `from`
/// stands in.
///
/// `from` is the start of a subpath: a point of the camera or of a light. This point may lie in the
/// plane of a surface, for example a pinhole in a wall. Rounding would then decide whether the ray
/// hits that surface and at which distance. The ray passes the surface instead, when `from` is in
/// its plane within the error of positions. A point with a `position_error` of its own is left
/// alone: `leave` has already moved its ray off the surface.
template <Scene Sc>
inline void pass_start(const Sc& scene, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
                       const Vec3<ScalarOf<typename Sc::Spectrum>>& direction, decltype(scene.intersect({}))& hit) {
  using T = ScalarOf<typename Sc::Spectrum>;
  if (!hit || from.position_error != T(0)) return;
  const Vec3<T> offset = hit->point.position - from.position;
  // `position_error` is at least eight times the rounding error of the hit position: an eighth of
  // it is the tolerance.
  if (T(8) * std::abs(glm::dot(offset, hit->point.geometric_normal)) <= hit->point.position_error) [[unlikely]]
    [&]() GMIS_RARE_LAMBDA { hit = scene.intersect(leave(hit->point, direction)); }();
}

/// The first hit of a ray that starts at a point of the camera or of a light, after `pass_start`;
/// nothing when the ray leaves the scene. `direction` has unit length.
template <Scene Sc>
[[nodiscard]] inline auto first_hit(const Sc& scene, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
                                    const Vec3<ScalarOf<typename Sc::Spectrum>>& direction) {
  auto hit = scene.intersect(leave(from, direction));
  pass_start(scene, from, direction, hit);
  return hit;
}

}  // namespace gmis
