#pragma once

#include <glm/geometric.hpp>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"

/// \file
/// Light that is absorbed between two surfaces, as in coloured glass. Nothing scatters there, so
/// absorption changes no density and no path weight: it is a factor on the throughput of both kinds
/// of subpath and on connections between vertices.

namespace gmis {

/// A scene with two optional members for absorption that depends on the ends of a segment, such as
/// on the medium on either side of a surface.
///
/// - `has_absorption()`: as in `SceneWithAbsorption`.
/// - `transmittance(ray, from, to)`: the share of the light, per channel, that passes along `ray`
///   from the point `from` to the point `to`, with their normals and tags. It is the same for the
///   way back, from `to` to `from`. One end may be a point of the camera or of a light, as these
///   made it; none belongs to an infinite light.
template <class S>
concept SceneWithAbsorptionBetween = Scene<S> &&
    requires(const S& scene, const Ray<ScalarOf<typename S::Spectrum>>& ray,
             const SurfacePoint<ScalarOf<typename S::Spectrum>>& from,
             const SurfacePoint<ScalarOf<typename S::Spectrum>>& to) {
  { scene.has_absorption() } -> std::same_as<bool>;
  { scene.transmittance(ray, from, to) } -> std::convertible_to<typename S::Spectrum>;
};

/// A scene with two optional members for absorption.
///
/// - `has_absorption()`: false promises that `transmittance` is 1 along every segment. It is read
///   once a segment.
/// - `transmittance(ray)`: the share of the light, per channel, that passes from one end of `ray`
///   to the other: exp(−∫σ) over 0 < t < `t_max`, which is finite, and where nothing blocks the
///   ray. It is the same for light that goes the other way. A scene may have
///   `transmittance(ray, from, to)` instead (`SceneWithAbsorptionBetween`), which takes precedence.
///
/// Light to and from infinite lights is not attenuated.
template <class S>
concept SceneWithAbsorption = SceneWithAbsorptionBetween<S> ||
    (Scene<S>&& requires(const S& scene, const Ray<ScalarOf<typename S::Spectrum>>& ray) {
      { scene.has_absorption() } -> std::same_as<bool>;
      { scene.transmittance(ray) } -> std::convertible_to<typename S::Spectrum>;
    });

/// True when light is absorbed somewhere in the scene. Where it is false, nothing else of this file
/// runs.
template <Scene Sc>
[[nodiscard]] constexpr bool absorbs(const Sc& scene) noexcept {
  if constexpr (SceneWithAbsorption<Sc>) {
    return scene.has_absorption();
  } else {
    constexpr bool has_one_of_two = requires(Sc & any) {
      any.has_absorption();
    }
    || requires(Sc & any, const Ray<ScalarOf<typename Sc::Spectrum>>& ray) {
      any.transmittance(ray);
    }
    || requires(Sc & any, const Ray<ScalarOf<typename Sc::Spectrum>>& ray,
                const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& end) {
      any.transmittance(ray, end, end);
    };
    static_assert(!has_one_of_two,
                  "absorption needs two members: bool has_absorption() const, and transmittance(ray) const or "
                  "transmittance(ray, from, to) const, which returns the Spectrum of the scene");
    return false;
  }
}

/// Transmittance along `ray` from the point `from` to the point `to`, per channel.
template <SceneWithAbsorption Sc>
[[nodiscard]] constexpr typename Sc::Spectrum transmittance_between(
    const Sc& scene, const Ray<ScalarOf<typename Sc::Spectrum>>& ray,
    [[maybe_unused]] const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
    [[maybe_unused]] const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& to) {
  if constexpr (SceneWithAbsorptionBetween<Sc>)
    return scene.transmittance(ray, from, to);
  else
    return scene.transmittance(ray);
}

/// Multiplies `value` by the transmittance of the segment from `from` along `direction` (unit) to
/// the point `to`, which is visible from there. Call it where `absorbs(scene)`.
template <Scene Sc>
GMIS_ALWAYS_INLINE inline void attenuate(const Sc& scene, const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& from,
                                         const Vec3<ScalarOf<typename Sc::Spectrum>>& direction,
                                         const SurfacePoint<ScalarOf<typename Sc::Spectrum>>& to,
                                         typename Sc::Spectrum& value) noexcept {
  if constexpr (SceneWithAbsorption<Sc>)
    value = value *
            transmittance_between(scene, leave(from, direction, glm::length(to.position - from.position)), from, to);
}

}  // namespace gmis
