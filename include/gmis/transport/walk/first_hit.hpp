#pragma once

#include <cmath>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// What a subpath meets first that starts at `from`, a point of the camera or of a light, along `direction`. A camera or a
/// point light may stand in a surface, where rounding decides whether its rays meet that surface, and how far away. They
/// do not: a surface in whose plane the start is, as far as positions are known, is passed.
///
/// `hit` is what `direction` meets, and becomes what comes after it where that is to be passed.
template <Scene Sc>
inline void pass_start(const Sc& scene, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
                       const Vec3<ScalarOf<typename Sc::Spectrum>>& direction, decltype(scene.intersect({}))& hit) {
  using T = ScalarOf<typename Sc::Spectrum>;
  if (!hit || from.position_error != T(0)) return;
  const Vec3<T> offset = hit->point.position - from.position;
  // A bound on the error of a position, with room for what follows; that of this one is at most an eighth of it.
  if (T(8) * std::abs(glm::dot(offset, hit->point.geometric_normal)) <= hit->point.position_error) [[unlikely]]
    [&]() __attribute__((cold, noinline)) {
      hit = scene.intersect(leave(hit->point, direction));
    }
  ();
}

/// The hit itself.
template <Scene Sc>
[[nodiscard]] inline auto first_hit(const Sc& scene, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
                                    const Vec3<ScalarOf<typename Sc::Spectrum>>& direction) {
  auto hit = scene.intersect(leave(from, direction));
  pass_start(scene, from, direction, hit);
  return hit;
}

}  // namespace gmis
