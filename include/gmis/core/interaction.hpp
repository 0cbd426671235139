#pragma once

#include <cstdint>
#include <limits>

#include "gmis/core/measure.hpp"
#include "gmis/core/spectrum.hpp"

/// \file
/// The plain data that passes between the user's scene and the transport layer. `T` is the scalar
/// (float or double), `S` the spectrum. Positions and distances are in scene units; directions have
/// unit length, are in the world frame and point away from the surface: `to_prev` to the previous
/// vertex of the subpath, `to_next` to the next one.

namespace gmis {

/// The quantity that a BSDF transports: `radiance` for a subpath that starts at the camera,
/// `importance` for a subpath that starts at a light. The two modes differ in refraction (radiance
/// scales with the square of the index, flux does not) and under shading normals [Veach 1997, ch.
/// 5].
enum class TransportMode { radiance, importance };

/// The points `origin` + t · `direction` with 0 < t < `t_max`.
template <std::floating_point T>
struct Ray {
  Vec3<T> origin;                                ///< where it starts
  Vec3<T> direction;                             ///< unit length
  T t_max = std::numeric_limits<T>::infinity();  ///< where it ends, in scene units
};

/// A point of a path. For a point on no surface (pinhole, point light) both normals are zero.
template <std::floating_point T>
struct SurfacePoint {
  Vec3<T> position;          ///< in scene units
  Vec3<T> geometric_normal;  ///< unit, on the surface's own side: not turned towards the ray
  Vec3<T> shading_normal;    ///< unit, in the hemisphere of the geometric normal
  /// Offset along the normal that is sure to clear the surface: a bound on the error of `position`,
  /// including the rounding of the offset itself. A scene that keeps rays off surfaces in another
  /// way leaves it 0.
  T position_error{};
  /// A number of the scene's own, such as that of the primitive. The engine never reads it, and
  /// keeps it wherever it keeps the point: `Light::emitted`, `next_event_density` and
  /// `sample_next_event`, the choice of a light for a receiver and `Scene::transmittance(ray, from,
  /// to)` receive it with the point. It must be a function of the point on the surface alone, not
  /// of the ray: `intersect` and the samples of a light give a point the same tag. 0 where it is
  /// not used.
  std::uint32_t tag = 0;
};

/// The ray that leaves `from` along `direction` (unit). Its origin is moved off the surface by
/// `position_error`, to the side that `direction` points to.
template <std::floating_point T>
[[nodiscard]] inline Ray<T> leave(const SurfacePoint<T>& from, const Vec3<T>& direction,
                                  T t_max = std::numeric_limits<T>::infinity()) noexcept {
  const T side = std::copysign(from.position_error, glm::dot(direction, from.geometric_normal));
  return {from.position + from.geometric_normal * side, direction, t_max};
}

/// The ray that tests whether `to` can be seen from `from`. Both ends are moved off their surfaces
/// towards each other. `direction` is the unit vector from `from` to `to`. When one of the points
/// lies on no surface, the ray starts at the other one: the start is sure to be on the right side
/// of all surfaces near it, whereas the rounding of the direction moves the far end. Points nearer
/// to each other than their offsets give an empty ray (`t_max` = 0): they see each other.
template <std::floating_point T>
[[nodiscard]] inline Ray<T> segment(const SurfacePoint<T>& from, const SurfacePoint<T>& to, const Vec3<T>& direction) {
  constexpr T nearly_one = T(1) - T(8) * std::numeric_limits<T>::epsilon();
  if (from.position_error == T(0)) [[unlikely]] {
    if (to.position_error > T(0)) return segment(to, from, -direction);
    const T length = glm::dot(to.position - from.position, direction);
    return {from.position, direction, length > T(0) ? length * nearly_one : T(0)};
  }
  const T from_side = std::copysign(from.position_error, glm::dot(direction, from.geometric_normal));
  // The error of a point on a ray grows with its distance from the start.
  const T reach = T(4) * std::numeric_limits<T>::epsilon() * glm::dot(to.position - from.position, direction);
  const T to_error = to.position_error > T(0) ? to.position_error + reach : T(0);
  const T to_side = std::copysign(to_error, -glm::dot(direction, to.geometric_normal));
  const Vec3<T> origin = from.position + from.geometric_normal * from_side;
  const Vec3<T> target = to.position + to.geometric_normal * to_side;
  const Vec3<T> between = target - origin;
  const T length = glm::length(between);
  // The offsets passed each other.
  if (!(length > T(0)) || glm::dot(between, direction) <= T(0)) return {origin, direction, T(0)};
  return {origin, between / length, length * nearly_one};
}

/// A BSDF for one pair of directions. `value` is f [1/sr] *without* the cosine and without delta
/// lobes. `pdf` holds the densities per steradian with which `sample` makes non-delta directions,
/// including the probability of choosing a lobe.
template <class S>
struct BsdfValue {
  /// The BSDF f [1/sr] without the cosine; delta lobes count as 0.
  S value{ScalarOf<S>(0)};
  DirectionPdfs<ScalarOf<S>> pdf{};  ///< densities of `to_next` and of `to_prev`, per steradian
};

/// A direction drawn at a surface. `weight` = f |cos| / pdf, with the cosine of the shading normal.
/// For a delta lobe (`is_delta`), `pdf` holds the selection probabilities of this lobe, forward and
/// reverse, and `weight` is the reflectance or transmittance of the lobe divided by the forward
/// selection probability.
template <class S>
struct ScatterSample {
  Vec3<ScalarOf<S>> to_next;  ///< unit, away from the surface
  S weight;                   ///< f |cos| / pdf; for a delta lobe see above
  /// Per steradian, with the choice of the lobe; selection probabilities of a delta lobe.
  DirectionPdfs<ScalarOf<S>> pdf;
  bool is_delta = false;  ///< the direction is that of a delta lobe
  ScalarOf<S> eta =
      ScalarOf<S>(1);  ///< index of refraction on the side of `to_next` over that on the side of `to_prev`
};

/// The hit of a ray: the point, the BSDF there, and the light that the surface belongs to (null
/// when it emits nothing).
template <std::floating_point T, class Bsdf_, class Light_>
struct Hit {
  using Bsdf = Bsdf_;
  using Light = Light_;
  SurfacePoint<T> point;         ///< where the ray met the surface
  Bsdf bsdf;                     ///< how the surface scatters there
  const Light* light = nullptr;  ///< the light that the surface is part of, or null
};

/// The densities of the start of a light subpath, without the probability of choosing the light.
///
/// | light | `origin` | `first` |
/// | --- | --- | --- |
/// | area | of the point, per area | of the direction, per steradian |
/// | point | 1 (the point is fixed) | of the direction, per steradian |
/// | directional | 1 (the direction is fixed) | of the point on the disk perpendicular to it, per area |
/// | environment | of the direction, per steradian | of the point on the disk perpendicular to it, per area |
template <std::floating_point T>
struct EmissionDensity {
  T origin{};  ///< of the point, or of the direction of an infinite light: see the table
  T first{};   ///< of the direction, or of the point on the disk: see the table
};

/// The start of a light subpath. `weight` is the flux divided by the densities: emitted radiance
/// · |cos| / (origin · first) for an area light, intensity / first for a point light, irradiance /
/// first for a directional light, radiance / (origin · first) for an environment. The cosine is
/// that of the geometric normal.
template <class S>
struct EmissionSample {
  SurfacePoint<ScalarOf<S>> origin;      ///< where the subpath starts
  Vec3<ScalarOf<S>> direction;           ///< unit, in which the light propagates
  S weight;                              ///< flux over the densities
  EmissionDensity<ScalarOf<S>> density;  ///< of this start
};

/// A sample of the light that arrives at a given point, the receiver. `weight` = incident radiance
/// / (density per steradian at the receiver); for a delta light it is the incident irradiance on a
/// plane perpendicular to the direction. The BSDF and the cosine of the receiver are not included.
template <class S>
struct NextEventSample {
  SurfacePoint<ScalarOf<S>> origin;      ///< on the light; not read for an infinite light
  Vec3<ScalarOf<S>> to_light;            ///< unit, from the receiver
  S weight;                              ///< incident radiance over the density at the receiver
  ScalarOf<S> next_event_density;        ///< density of `origin`, in the measure of `EmissionDensity::origin`
  EmissionDensity<ScalarOf<S>> density;  ///< density of emission from `origin` towards the receiver
};

/// The radiance that a light emits at one of its points along one direction, and the density of
/// that emission; both 0 where it emits nothing, and for a delta light.
template <class S>
struct Emitted {
  /// Per steradian and area perpendicular to the direction.
  S radiance{ScalarOf<S>(0)};
  EmissionDensity<ScalarOf<S>> density{};  ///< with which `sample_emission` makes this start
};

/// A light and the probability of choosing it.
template <std::floating_point T, class Light>
struct LightChoice {
  const Light* light;       ///< null when the scene has no light
  T selection_probability;  ///< with which it was chosen
};

/// A camera ray through one pixel. `weight` is the factor on the incident radiance (1 for an ideal
/// pinhole, whose pixel value is the mean radiance over the pixel). `density` is the density of the
/// rays of this pixel: per steradian, or per area perpendicular to the ray for a camera with
/// parallel rays.
template <class S>
struct CameraSample {
  SurfacePoint<ScalarOf<S>> origin;  ///< on the lens
  Vec3<ScalarOf<S>> direction;       ///< unit, from the lens into the scene
  S weight;                          ///< factor on the incident radiance
  ScalarOf<S> density;               ///< of the rays of one pixel: per steradian, or per area for parallel rays
};

/// The projection of a point: the pixel that sees it, the point of the lens, and the density of
/// that pixel's camera rays along this direction. `weight` and `density` are those of
/// `CameraSample`.
template <class S>
struct CameraProjection {
  glm::ivec2 pixel;                  ///< x to the right, y down, from the upper left
  SurfacePoint<ScalarOf<S>> origin;  ///< where the subpath starts
  Vec3<ScalarOf<S>> to_camera;       ///< unit, from the point
  S weight;                          ///< that of `CameraSample` for this direction
  ScalarOf<S> density;               ///< of the rays of one pixel: per steradian, or per area for parallel rays
};

}  // namespace gmis
