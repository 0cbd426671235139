#pragma once

#include <limits>

#include "gmis/core/measure.hpp"
#include "gmis/core/spectrum.hpp"

/// \file
/// The plain data that passes between the user's scene and the transport layer. `T` is the scalar (float or double),
/// `S` the spectrum. Positions and distances are in scene units; directions have unit length, are in the world frame
/// and point away from the surface: `to_prev` to where the subpath came from, `to_next` to where it goes.

namespace gmis {

/// What a subpath carries: `radiance` when it started at the camera, `importance` when it started at a light (the adjoint
/// quantity, flux). The two differ in refraction (radiance scales with the square of the index, flux does not) and under
/// shading normals [Veach 1997, ch. 5].
enum class TransportMode { radiance, importance };

template <std::floating_point T>
struct Ray {
  Vec3<T> origin;
  Vec3<T> direction;  ///< unit length
  T t_max = std::numeric_limits<T>::infinity();
};

/// A point of a path. For a point on no surface (pinhole, point light) both normals are zero.
template <std::floating_point T>
struct SurfacePoint {
  Vec3<T> position;
  Vec3<T> geometric_normal;  ///< unit, the surface's own side: not turned towards the ray
  Vec3<T> shading_normal;    ///< unit, in the hemisphere of the geometric normal
  /// A distance along the normal that is sure to clear the surface: a bound on the error of `position`, with the
  /// rounding of the offset itself. A scene that keeps its rays off surfaces by other means leaves it 0.
  T position_error{};
};

/// The ray that leaves `from` along `direction`, its origin moved off the surface by the error bound, to that side of
/// the surface which the direction points to.
template <std::floating_point T>
[[nodiscard]] inline Ray<T> leave(const SurfacePoint<T>& from, const Vec3<T>& direction,
                                  T t_max = std::numeric_limits<T>::infinity()) noexcept {
  const T side = std::copysign(from.position_error, glm::dot(direction, from.geometric_normal));
  return {from.position + from.geometric_normal * side, direction, t_max};
}

/// The ray to test whether `to` can be seen from `from`: both ends are moved off their surfaces towards each other.
/// `direction` is the unit vector between the two positions. The ray starts on a surface where there is one: there it is
/// sure to be on the right side of all surfaces near by, and where it ends the rounding of its direction has taken it some
/// way off.
template <std::floating_point T>
[[nodiscard]] inline Ray<T> segment(const SurfacePoint<T>& from, const SurfacePoint<T>& to, const Vec3<T>& direction) {
  if (from.position_error == T(0) && to.position_error > T(0)) [[unlikely]]
    return segment(to, from, -direction);
  const T from_side = std::copysign(from.position_error, glm::dot(direction, from.geometric_normal));
  // How far a ray passes from where it should grows with the way it has gone.
  const T reach = T(4) * std::numeric_limits<T>::epsilon() * glm::dot(to.position - from.position, direction);
  const T to_error = to.position_error > T(0) ? to.position_error + reach : T(0);
  const T to_side = std::copysign(to_error, -glm::dot(direction, to.geometric_normal));
  const Vec3<T> origin = from.position + from.geometric_normal * from_side;
  const Vec3<T> target = to.position + to.geometric_normal * to_side;
  const Vec3<T> between = target - origin;
  const T length = glm::length(between);
  // Two points nearer to each other than their offsets see each other.
  if (!(length > T(0)) || glm::dot(between, direction) <= T(0)) return {origin, direction, T(0)};
  return {origin, between / length, length * (T(1) - T(8) * std::numeric_limits<T>::epsilon())};
}

/// A BSDF at one pair of directions: `value` is f [1/sr] *without* the cosine, delta lobes left out; the densities are
/// those with which `sample` makes non-delta directions, the chance of choosing a lobe included.
template <Spectrum S>
struct BsdfValue {
  S value{ScalarOf<S>(0)};
  DirectionPdfs<ScalarOf<S>> pdf{};
};

/// A direction drawn at a surface. `weight` = f |cos| / pdf, the cosine taken with the shading normal. For a delta lobe
/// (`is_delta`) the two densities hold the selection probabilities of that lobe, forward and reverse, and `weight` is
/// the lobe's reflectance or transmittance divided by the forward one.
template <Spectrum S>
struct ScatterSample {
  Vec3<ScalarOf<S>> to_next;
  S weight;
  DirectionPdfs<ScalarOf<S>> pdf;
  bool is_delta = false;
  ScalarOf<S> eta =
      ScalarOf<S>(1);  ///< index of refraction on the side of `to_next` over that on the side of `to_prev`
};

/// What a ray met: where, how it scatters there, and the light that the surface is (null when it emits nothing).
template <std::floating_point T, class Bsdf_, class Light_>
struct Hit {
  using Bsdf = Bsdf_;
  using Light = Light_;
  SurfacePoint<T> point;
  Bsdf bsdf;
  const Light* light = nullptr;
};

/// The densities with which light subpaths start, without the probability of choosing the light.
///
/// | light | `origin` | `first` |
/// | --- | --- | --- |
/// | area | of the point, per area | of the direction, per steradian |
/// | point | 1 (the point is fixed) | of the direction, per steradian |
/// | directional | 1 (the direction is fixed) | of the point on the disk perpendicular to it, per area |
/// | environment | of the direction, per steradian | of the point on the disk perpendicular to it, per area |
template <std::floating_point T>
struct EmissionDensity {
  T origin{};
  T first{};
};

/// The start of a light subpath. `weight` = emitted radiance · |cos| / (origin · first) for an area light, intensity /
/// first for a point, irradiance / first for a directional light, radiance / (origin · first) for an environment.
template <Spectrum S>
struct EmissionSample {
  SurfacePoint<ScalarOf<S>> origin;
  Vec3<ScalarOf<S>> direction;  ///< the way the light goes
  S weight;
  EmissionDensity<ScalarOf<S>> density;
};

/// Light on its way to a given point. `weight` = incident radiance / (density per steradian at that point), or the
/// incident irradiance on a plane perpendicular to it for a delta light; the receiver's BSDF and cosine are not in.
template <Spectrum S>
struct NextEventSample {
  SurfacePoint<ScalarOf<S>> origin;  ///< on the light; for an infinite light only the normals (zero) are read
  Vec3<ScalarOf<S>> to_light;        ///< from the receiver
  S weight;
  ScalarOf<S> next_event_density;        ///< of `origin` in the measure of `EmissionDensity::origin`
  EmissionDensity<ScalarOf<S>> density;  ///< of emission from `origin` towards the receiver
};

/// What a light sends from one of its points along one direction.
template <Spectrum S>
struct Emitted {
  S radiance{ScalarOf<S>(0)};
  EmissionDensity<ScalarOf<S>> density{};
};

template <std::floating_point T, class Light>
struct LightChoice {
  const Light* light;
  T selection_probability;
};

/// A camera ray through one pixel. `weight` multiplies the radiance that comes back (1 for an ideal pinhole whose pixel
/// value is the mean radiance over the pixel). `density` is that of the ray for this pixel: per steradian, or per area
/// perpendicular to the ray for a camera with parallel rays.
template <Spectrum S>
struct CameraSample {
  SurfacePoint<ScalarOf<S>> origin;  ///< on the lens
  Vec3<ScalarOf<S>> direction;
  S weight;
  ScalarOf<S> density;
};

/// How a point is seen by the camera: the pixel it falls in, the point of the lens, and the density with which that
/// pixel's camera rays would take this way (as `CameraSample::density`). `weight` as there.
template <Spectrum S>
struct CameraProjection {
  glm::ivec2 pixel;
  SurfacePoint<ScalarOf<S>> origin;
  Vec3<ScalarOf<S>> to_camera;  ///< from the point
  S weight;
  ScalarOf<S> density;
};

}  // namespace gmis
