#pragma once

#include <cstdint>
#include <optional>

#include "gmis/core/attributes.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene/edge_margin.hpp"
#include "gmis/scene/emission_pattern.hpp"
#include "gmis/scene/environment_map.hpp"
#include "gmis/scene/light_bounds.hpp"
#include "gmis/scene/light_reach.hpp"
#include "gmis/scene/spot_cone.hpp"

namespace gmis::scene {

/// A light source, made by one of the functions below. Models `gmis::Light`. Colours are linear
/// RGB.
///
/// An area light emits on the side of its geometric normal, or on both sides: constant radiance, or
/// that of a pattern over a triangle. Points are drawn uniformly by area, except that next events
/// at a sphere from outside are uniform over its solid angle. The light subpaths of an infinite
/// light start on a disk as wide as the bounding ball of the scene, which `enclose` sets.
template <std::floating_point T = float>
class Light {
 public:
  using Spectrum = Vec3<T>;
  using Point = SurfacePoint<T>;

  /// A triangle of a mesh. `radiance` is per steradian and projected area; `normal` has unit
  /// length. Sample points keep a distance from the `sharp` edges (edge_margin.hpp). With a
  /// `pattern`, which must outlive the light, `radiance` is its mean (which decides the power), and
  /// `uv` are the coordinates of the corners.
  [[nodiscard]] static Light triangle(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c, const Vec3<T>& normal,
                                      T position_error, const Spectrum& radiance, bool two_sided, SharpEdges sharp = 0,
                                      const EmissionPattern<T>* pattern = nullptr,
                                      const TriangleCoordinates<T>& uv = {}) noexcept {
    Light light(Kind::triangle, radiance);
    light.origin_ = a;
    light.edge_b_ = b - a;
    light.edge_c_ = c - a;
    light.normal_ = normal;
    light.position_error_ = position_error;
    light.is_two_sided_ = two_sided;
    light.inverse_area_ = T(2) / glm::length(glm::cross(light.edge_b_, light.edge_c_));
    // Points are drawn from a smaller triangle, which keeps its distance from the sharp edges.
    const Vec3<T> margins = edge_margins({a, b, c}, sharp, position_error);
    const T rest = T(1) - (margins.x + margins.y + margins.z);
    light.origin_ = a * (margins.x + rest) + b * margins.y + c * margins.z;
    light.edge_b_ = light.edge_b_ * rest;
    light.edge_c_ = light.edge_c_ * rest;
    light.pattern_ = pattern;
    light.uv_ = {uv[0] * (margins.x + rest) + uv[1] * margins.y + uv[2] * margins.z, (uv[1] - uv[0]) * rest,
                 (uv[2] - uv[0]) * rest};
    return light;
  }
  /// A sphere. `radiance` is per steradian and projected area. Without `two_sided` it emits on the
  /// side of its normal.
  [[nodiscard]] static Light sphere(const Vec3<T>& center, T radius, bool normal_points_inward, T position_error,
                                    const Spectrum& radiance, bool two_sided) noexcept {
    Light light(Kind::sphere, radiance);
    light.origin_ = center;
    light.radius_ = radius;
    light.side_ = normal_points_inward ? T(-1) : T(1);
    light.position_error_ = position_error;
    light.is_two_sided_ = two_sided;
    light.inverse_area_ = T(1) / (T(4) * pi<T> * radius * radius);
    return light;
  }
  /// A point light; `intensity` is flux per steradian.
  [[nodiscard]] static Light point(const Vec3<T>& position, const Spectrum& intensity) noexcept {
    Light light(Kind::point, intensity);
    light.origin_ = position;
    return light;
  }
  /// A spot light; `intensity` is flux per steradian along the axis of `cone`, which is also its
  /// maximum.
  [[nodiscard]] static Light spot(const Vec3<T>& position, const SpotCone<T>& cone,
                                  const Spectrum& intensity) noexcept {
    Light light(Kind::spot, intensity);
    light.origin_ = position;
    light.cone_ = cone;
    return light;
  }
  /// A directional light; `irradiance` is that on a plane perpendicular to the unit vector
  /// `to_light`.
  [[nodiscard]] static Light directional(const Vec3<T>& to_light, const Spectrum& irradiance) noexcept {
    Light light(Kind::directional, irradiance);
    light.normal_ = to_light;
    return light;
  }
  /// An environment with the same `radiance` from all directions.
  [[nodiscard]] static Light environment(const Spectrum& radiance) noexcept {
    return Light(Kind::environment, radiance);
  }
  /// An environment with the radiance of an image. `map` must outlive the light and must not be
  /// black.
  [[nodiscard]] static Light environment(const EnvironmentMap<T>& map) noexcept {
    Light light(Kind::image, Spectrum(T(1)));
    light.map_ = &map;
    return light;
  }

  /// Sets the bounding ball of the scene. It affects infinite lights only, which need it before
  /// they are sampled.
  void enclose(const Vec3<T>& center, T radius) noexcept {
    if (!is_infinite()) return;
    origin_ = center;
    radius_ = radius;
    inverse_area_ = T(1) / (pi<T> * radius * radius);
  }

  /// Total flux, mean of the channels; for an infinite light the flux through its disk.
  [[nodiscard]] double power() const noexcept {
    const double mean = static_cast<double>(mean_channel(emission_));
    switch (kind_) {
      case Kind::triangle:
      case Kind::sphere:
        return mean * pi<double> * (is_two_sided_ ? 2 : 1) / static_cast<double>(inverse_area_);
      case Kind::point:
        return mean * 4 * pi<double>;
      case Kind::spot:
        return mean * static_cast<double>(cone_.solid_angle());
      case Kind::directional:
        return mean / static_cast<double>(inverse_area_);
      case Kind::environment:
        return mean * 4 * pi<double> / static_cast<double>(inverse_area_);
      case Kind::image:
        return map_->total() / static_cast<double>(inverse_area_);
    }
    return 0;
  }

  /// The power by which a scene chooses the light. A uniform sky counts a sixteenth of its power:
  /// rays that BSDFs choose find it as well as next events do.
  [[nodiscard]] double power_to_choose_by() const noexcept {
    return kind_ == Kind::environment ? power() / 16 : power();
  }

  /// Where a light with a position is and in which directions it shines.
  [[nodiscard]] LightBounds bounds() const noexcept {
    LightBounds bounds;
    bounds.power = power();
    bounds.box.add(glm::dvec3(origin_));
    if (kind_ == Kind::triangle) {
      bounds.box.add(glm::dvec3(origin_ + edge_b_));
      bounds.box.add(glm::dvec3(origin_ + edge_c_));
      bounds.axis = glm::dvec3(normal_);
      if (!is_two_sided_) bounds.spread = 0;
    } else if (kind_ == Kind::sphere) {
      bounds.box.add(glm::dvec3(origin_) - static_cast<double>(radius_));
      bounds.box.add(glm::dvec3(origin_) + static_cast<double>(radius_));
    } else if (kind_ == Kind::spot) {
      bounds.axis = glm::dvec3(cone_.axis());
      bounds.spread = cone_.outer_angle();
      bounds.emission = 0;
    }
    return bounds;
  }

  /// Upper bound of the share of the flux that meets the ball, in [0, 1]; 1 for an infinite light.
  [[nodiscard]] double share_towards(const ReceiverBall& ball) const noexcept {
    const auto from = [&](const glm::dvec3& middle) { return glm::length(ball.center - middle); };
    const auto cosine = [&](const glm::dvec3& middle, const Vec3<T>& axis) {
      return glm::dot(ball.center - middle, glm::dvec3(axis)) / std::max(from(middle), 1e-300);
    };
    glm::dvec3 middle(origin_);
    switch (kind_) {
      case Kind::triangle: {
        const glm::dvec3 b(edge_b_), c(edge_c_), to_middle = (b + c) / 3.0;
        middle += to_middle;
        const double own = std::max({glm::length(to_middle), glm::length(b - to_middle), glm::length(c - to_middle)});
        const double area = inverse_area_ > 0 ? 1.0 / static_cast<double>(inverse_area_) : 0.0;
        return share_of_facet(from(middle), cosine(middle, normal_), own, area, is_two_sided_, ball.radius);
      }
      case Kind::sphere:
        return share_of_sphere(from(middle), static_cast<double>(radius_), ball.radius);
      case Kind::point:
        return share_of_point(from(middle), ball.radius);
      case Kind::spot:
        return share_of_spot(from(middle), std::acos(std::clamp(cosine(middle, cone_.axis()), -1.0, 1.0)),
                             cone_.outer_angle(), static_cast<double>(cone_.solid_angle()), ball.radius);
      default:
        return 1.0;
    }
  }

  /// True for a light that no ray can hit.
  [[nodiscard]] bool is_delta() const noexcept {
    return kind_ == Kind::point || kind_ == Kind::spot || kind_ == Kind::directional;
  }
  /// True for a light without a position: directional lights and environments.
  [[nodiscard]] bool is_infinite() const noexcept {
    return kind_ == Kind::directional || kind_ == Kind::environment || kind_ == Kind::image;
  }
  /// A point light within a cone.
  [[nodiscard]] bool is_spot() const noexcept { return kind_ == Kind::spot; }
  /// The probability with which the scene chooses this light; the scene sets it.
  [[nodiscard]] T selection_probability() const noexcept { return selection_probability_; }
  /// Called by the scene once all lights are known.
  void set_selection_probability(T probability) noexcept { selection_probability_ = probability; }

  /// The group that this light belongs to, for pictures by light; the scene sets it.
  [[nodiscard]] std::uint16_t group() const noexcept { return group_; }
  /// Sets that group.
  void set_group(std::uint16_t group) noexcept { group_ = group; }

  /// A sample of the light that arrives at `from`. Nothing when the sampled point sends no light
  /// there or coincides with `from`.
  [[nodiscard]] std::optional<NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                           const Vec2<T>& uv) const noexcept {
    switch (kind_) {
      case Kind::triangle:
        return toward(uniform_point(uv), from, inverse_area_);
      case Kind::sphere:
        return sample_sphere(from, uv);
      case Kind::point:
      case Kind::spot: {
        const Vec3<T> offset = origin_ - from.position;
        const T distance_squared = glm::dot(offset, offset);
        if (!(distance_squared > T(0))) return std::nullopt;
        const Vec3<T> to_light = offset * (T(1) / std::sqrt(distance_squared));
        const T falloff = kind_ == Kind::spot ? cone_.falloff(-to_light) : T(1);
        if (!(falloff > T(0))) return std::nullopt;
        const T density = kind_ == Kind::spot ? falloff / cone_.solid_angle() : uniform_sphere;
        return NextEventSample<Spectrum>{
            place(), to_light, emission_ * (falloff / distance_squared), T(1), {T(1), density}};
      }
      case Kind::directional:
        return NextEventSample<Spectrum>{{}, normal_, emission_, T(1), {T(1), inverse_area_}};
      case Kind::environment:
        return NextEventSample<Spectrum>{
            {}, square_to_sphere(uv), emission_ * (T(4) * pi<T>), uniform_sphere, {uniform_sphere, inverse_area_}};
      case Kind::image: {
        const auto sky = map_->sample_next_event(uv);
        if (!(sky.density > T(0))) return std::nullopt;
        return NextEventSample<Spectrum>{{},
                                         sky.to_sky,
                                         sky.radiance * (T(1) / sky.density),
                                         sky.density,
                                         {map_->density(sky.radiance), inverse_area_}};
      }
    }
    return std::nullopt;
  }

  /// The start of a light subpath. An area light draws a uniform point and a cosine-distributed
  /// direction. Nothing when the density of the direction is 0.
  [[nodiscard]] std::optional<EmissionSample<Spectrum>> sample_emission(const Vec2<T>& uv_origin,
                                                                        const Vec2<T>& uv_direction) const noexcept {
    switch (kind_) {
      case Kind::triangle:
      case Kind::sphere:
        return emit_from_area(uniform_point(uv_origin), uv_direction);
      case Kind::point:
        return EmissionSample<Spectrum>{
            place(), square_to_sphere(uv_direction), emission_ * (T(4) * pi<T>), {T(1), uniform_sphere}};
      case Kind::spot: {
        const auto drawn = cone_.sample(uv_direction);
        if (!(drawn.density > T(0))) return std::nullopt;
        return EmissionSample<Spectrum>{
            place(), drawn.direction, emission_ * cone_.solid_angle(), {T(1), drawn.density}};
      }
      case Kind::directional:
        return EmissionSample<Spectrum>{
            disk_point(normal_, uv_origin), -normal_, emission_ * (T(1) / inverse_area_), {T(1), inverse_area_}};
      case Kind::environment: {
        const Vec3<T> to_sky = square_to_sphere(uv_direction);
        return EmissionSample<Spectrum>{disk_point(to_sky, uv_origin),
                                        -to_sky,
                                        emission_ * (T(4) * pi<T> / inverse_area_),
                                        {uniform_sphere, inverse_area_}};
      }
      case Kind::image: {
        const auto sky = map_->sample(uv_direction);
        return EmissionSample<Spectrum>{disk_point(sky.to_sky, uv_origin),
                                        -sky.to_sky,
                                        sky.radiance * (T(1) / (sky.density * inverse_area_)),
                                        {sky.density, inverse_area_}};
      }
    }
    return std::nullopt;
  }

  /// The start that `sample_emission` makes at `origin` along `direction` (`GuidableLight`).
  /// Nothing on a side that does not emit, and for a line that misses the bounding ball of the
  /// scene.
  [[nodiscard]] std::optional<EmissionSample<Spectrum>> emission_along(const Point& origin,
                                                                       const Vec3<T>& direction) const noexcept {
    switch (kind_) {
      case Kind::triangle:
      case Kind::sphere: {
        const T cosine = glm::dot(origin.geometric_normal, direction);
        if (!emits_at(cosine)) return std::nullopt;
        return area_emission(origin, direction, cosine);
      }
      case Kind::point:
        return EmissionSample<Spectrum>{
            place(), direction, emission_ * (T(1) / uniform_sphere), {T(1), uniform_sphere}};
      case Kind::spot: {
        const T falloff = cone_.falloff(direction);
        if (!(falloff > T(0))) return std::nullopt;
        return EmissionSample<Spectrum>{
            place(), direction, emission_ * cone_.solid_angle(), {T(1), falloff / cone_.solid_angle()}};
      }
      case Kind::directional:
      case Kind::environment:
      case Kind::image:
        return infinite_emission(origin.position, direction);
    }
    return std::nullopt;
  }

  /// The random numbers from which `sample_emission` makes the point of an area light, or the
  /// direction of a uniform environment (`GuidableLight`). Nothing for a light that draws neither,
  /// and for an image: its alias tables have no inverse.
  [[nodiscard]] std::optional<Vec2<T>> start_numbers(const Point& origin, const Vec3<T>& direction) const noexcept {
    switch (kind_) {
      case Kind::triangle:
        return triangle_to_square(barycentric(origin.position));
      case Kind::sphere:
        return sphere_to_square(glm::normalize(origin.position - origin_));
      case Kind::environment:
        return sphere_to_square(-direction);
      default:
        return std::nullopt;
    }
  }

  /// Radiance from `origin` along `direction` and the densities of `sample_emission` there; 0 for a
  /// delta light and on a side that does not emit.
  [[nodiscard]] Emitted<Spectrum> emitted(const Point& origin, const Vec3<T>& direction) const noexcept {
    switch (kind_) {
      case Kind::triangle:
      case Kind::sphere: {
        const T cosine = glm::dot(origin.geometric_normal, direction);
        if (!emits_at(cosine)) return {};
        return {radiance_at(origin.position), area_density(cosine)};
      }
      case Kind::environment:
        return {emission_, {uniform_sphere, inverse_area_}};
      case Kind::image: {
        const Spectrum radiance = map_->radiance(-direction);
        return {radiance, {map_->density(radiance), inverse_area_}};
      }
      default:
        return {};
    }
  }

  /// Density with which `sample_next_event(from, …)` makes `origin`, in the measure of
  /// `EmissionDensity::origin`.
  [[nodiscard]] T next_event_density(const Point& origin, const Vec3<T>& direction, const Point& from) const noexcept {
    switch (kind_) {
      case Kind::triangle:
        return inverse_area_;
      case Kind::sphere: {
        const T drop = cone_drop(from.position);
        if (drop < T(0)) return inverse_area_;
        const Vec3<T> offset = origin.position - from.position;
        return solid_angle_per_area(glm::dot(origin.geometric_normal, direction), glm::dot(offset, offset)) /
               (T(2) * pi<T> * drop);
      }
      case Kind::environment:
        return uniform_sphere;
      case Kind::image:
        return map_->next_event_density(map_->radiance(-direction));
      default:
        return T(1);
    }
  }

 private:
  enum class Kind : std::uint8_t { triangle, sphere, point, spot, directional, environment, image };
  static constexpr T uniform_sphere = T(1) / (T(4) * pi<T>);

  Light(Kind kind, const Spectrum& emission) noexcept : kind_(kind), emission_(emission) {}

  [[nodiscard]] bool emits_at(T cosine) const noexcept { return cosine > T(0) || (is_two_sided_ && cosine < T(0)); }
  /// Densities of emission by an area light: uniform per area, |cos|/π per steradian on each side
  /// that emits.
  [[nodiscard]] EmissionDensity<T> area_density(T cosine) const noexcept {
    return {inverse_area_, std::abs(cosine) * (is_two_sided_ ? T(0.5) / pi<T> : T(1) / pi<T>)};
  }
  [[nodiscard]] Point place() const noexcept { return {origin_, {}, {}, T(0)}; }
  [[nodiscard]] Point on_sphere(const Vec3<T>& outward) const noexcept {
    const Vec3<T> normal = outward * side_;
    return {origin_ + outward * radius_, normal, normal, position_error_};
  }
  /// A uniform point on an area light.
  [[nodiscard]] Point uniform_point(const Vec2<T>& uv) const noexcept {
    if (kind_ == Kind::sphere) return on_sphere(square_to_sphere(uv));
    const Vec2<T> b = square_to_triangle(uv);
    return {origin_ + edge_b_ * b.x + edge_c_ * b.y, normal_, normal_, position_error_};
  }

  /// The sample for a point `origin` on an area light that was drawn with `density` per area.
  [[nodiscard]] std::optional<NextEventSample<Spectrum>> toward(const Point& origin, const Point& from,
                                                                T density) const noexcept {
    const Vec3<T> offset = origin.position - from.position;
    const T distance_squared = glm::dot(offset, offset);
    if (!(distance_squared > T(0))) return std::nullopt;
    const Vec3<T> to_light = offset * (T(1) / std::sqrt(distance_squared));
    const T cosine = -glm::dot(origin.geometric_normal, to_light);
    if (!emits_at(cosine)) return std::nullopt;
    return NextEventSample<Spectrum>{origin, to_light,
                                     radiance_at(origin.position) * (std::abs(cosine) / (distance_squared * density)),
                                     density, area_density(cosine)};
  }

  /// 1 − cos of the half angle of the sphere seen from `from`; −1 inside or on the sphere, within
  /// the error of positions. A point on the inner side may be rounded outwards and must still count
  /// as inside.
  [[nodiscard]] T cone_drop(const Vec3<T>& from) const noexcept {
    const Vec3<T> offset = origin_ - from;
    const T distance_squared = glm::dot(offset, offset);
    if (!(distance_squared > square(radius_ + position_error_))) return T(-1);
    const T sin2 = square(radius_) / distance_squared;
    return sin2 / (T(1) + std::sqrt(T(1) - sin2));
  }

  /// Seen from outside, the sample is uniform over the solid angle of the sphere; from inside, it
  /// is uniform over the area.
  [[nodiscard]] GMIS_NEVER_INLINE std::optional<NextEventSample<Spectrum>> sample_sphere(const Point& from,
                                                                                         Vec2<T> uv) const noexcept {
    const T drop = cone_drop(from.position);
    if (drop < T(0)) return toward(uniform_point(uv), from, inverse_area_);
    const Vec3<T> offset = origin_ - from.position;
    const T distance = glm::length(offset);
    const Vec3<T> local = square_to_cone(uv, drop);
    // The angle at the centre between the receiver and the point that the direction meets first.
    const T sin2 = local.x * local.x + local.y * local.y;
    const T chord = sqrt_or_zero(square(radius_) - square(distance) * sin2);
    const T along = distance * local.z - chord;
    const Frame<T> frame = Frame<T>::around(offset * (T(1) / distance));
    const Vec3<T> outward = glm::normalize(frame.to_world(local) * along - offset);
    const Point origin = on_sphere(outward);
    const Vec3<T> to_origin = origin.position - from.position;
    const T distance_squared = glm::dot(to_origin, to_origin);
    const Vec3<T> to_light = to_origin * (T(1) / std::sqrt(distance_squared));
    const T cosine = -glm::dot(origin.geometric_normal, to_light);
    if (!emits_at(cosine)) return std::nullopt;
    const T solid_angle = T(2) * pi<T> * drop;
    return NextEventSample<Spectrum>{origin, to_light, emission_ * solid_angle,
                                     std::abs(cosine) / (distance_squared * solid_angle), area_density(cosine)};
  }

  [[nodiscard]] std::optional<EmissionSample<Spectrum>> emit_from_area(const Point& origin, Vec2<T> uv) const noexcept {
    T side = T(1);
    if (is_two_sided_) {
      side = uv.x < T(0.5) ? T(1) : T(-1);
      uv.x = T(2) * uv.x - (side > T(0) ? T(0) : T(1));
    }
    const Vec3<T> local = square_to_cosine_hemisphere(uv);
    if (!(local.z > T(0))) return std::nullopt;
    const Vec3<T> direction = Frame<T>::around(origin.geometric_normal).to_world({local.x, local.y, local.z * side});
    return area_emission(origin, direction, local.z);
  }
  [[nodiscard]] EmissionSample<Spectrum> area_emission(const Point& origin, const Vec3<T>& direction,
                                                       T cosine) const noexcept {
    return {origin, direction, radiance_at(origin.position) * (pi<T> * (is_two_sided_ ? T(2) : T(1)) / inverse_area_),
            area_density(cosine)};
  }
  /// The start on the disk of the line through `on_line`; nothing when the line misses the bounding
  /// ball.
  [[nodiscard]] std::optional<EmissionSample<Spectrum>> infinite_emission(const Vec3<T>& on_line,
                                                                          const Vec3<T>& direction) const noexcept {
    const Vec3<T> offset = on_line - origin_;
    const T along = glm::dot(offset, direction);
    if (!(glm::dot(offset, offset) - along * along <= square(radius_))) return std::nullopt;
    const Point start{on_line - direction * (radius_ + along), {}, {}, T(0)};
    T density(1);  // of the direction
    Spectrum light = emission_;
    if (kind_ == Kind::environment) density = uniform_sphere;
    if (kind_ == Kind::image) {
      light = map_->radiance(-direction);
      density = map_->density(light);
      if (!(density > T(0))) return std::nullopt;
    }
    return EmissionSample<Spectrum>{
        start, direction, light * (T(1) / (density * inverse_area_)), {density, inverse_area_}};
  }
  /// Radiance that an area light emits at a point of it.
  [[nodiscard]] Spectrum radiance_at(const Vec3<T>& position) const noexcept {
    return pattern_ == nullptr ? emission_ : radiance_of_pattern(position);
  }
  /// `radiance_at` where there is a pattern: few lights have one, so the others do not pay for it.
  [[nodiscard]] GMIS_RARE Spectrum radiance_of_pattern(const Vec3<T>& position) const noexcept {
    const Vec2<T> b = barycentric(position);
    SurfaceCoordinates<T> at;
    at.uv = uv_[0] + uv_[1] * b.x + uv_[2] * b.y;
    at.position = position;
    at.set_cell(position_error_);
    return pattern_->at(at);
  }
  /// Barycentric coordinates (of the second and third corner) of a point of the triangle that
  /// points are drawn from.
  [[nodiscard]] Vec2<T> barycentric(const Vec3<T>& position) const noexcept {
    const Vec3<T> offset = position - origin_, normal = glm::cross(edge_b_, edge_c_);
    const T inverse = T(1) / glm::dot(normal, normal);
    return {glm::dot(glm::cross(offset, edge_c_), normal) * inverse,
            glm::dot(glm::cross(edge_b_, offset), normal) * inverse};
  }

  /// A uniform point on the disk that touches the bounding ball on the side of `to_light`.
  [[nodiscard]] Point disk_point(const Vec3<T>& to_light, const Vec2<T>& uv) const noexcept {
    const Vec2<T> disk = square_to_disk(uv) * radius_;
    const Frame<T> frame = Frame<T>::around(to_light);
    return {origin_ + frame.tangent * disk.x + frame.bitangent * disk.y + to_light * radius_, {}, {}, T(0)};
  }

  Kind kind_;
  bool is_two_sided_ = false;
  std::uint16_t group_ = 0;
  Spectrum emission_;  ///< radiance (of a pattern: about its mean), intensity or irradiance
  Vec3<T> origin_{};   ///< first corner, centre, position, or centre of the bounding ball
  Vec3<T> normal_{};   ///< normal of a triangle, or direction towards a directional light
  Vec3<T> edge_b_{}, edge_c_{};
  T radius_ = 0;        ///< radius of a sphere or of the bounding ball
  T side_ = 1;          ///< −1 when the normal of a sphere points inward
  T inverse_area_ = 0;  ///< 1 / area of the surface or of the disk
  T position_error_ = 0;
  T selection_probability_ = 0;
  SpotCone<T> cone_{};
  const EnvironmentMap<T>* map_ = nullptr;
  const EmissionPattern<T>* pattern_ = nullptr;
  TriangleCoordinates<T> uv_{};  ///< of a pattern: at `origin_`, and their change along the two edges
};

static_assert(gmis::GuidableLight<Light<float>>);
static_assert(gmis::GuidableLight<Light<double>>);

}  // namespace gmis::scene
