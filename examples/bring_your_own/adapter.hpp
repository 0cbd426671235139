#pragma once

#include <gmis/core/concept_diagnostics.hpp>
#include <gmis/core/effects.hpp>

#include "their_renderer.hpp"

/// \file
/// The adapter: everything that gmis needs to know of the renderer in their_renderer.hpp.

namespace adapter {
using Spectrum = glm::dvec3;  // RGB in double
using Point = gmis::SurfacePoint<double>;
using glm::dvec3;
inline constexpr auto ours = [](const theirs::Vector& v) { return dvec3(v.x, v.y, v.z); };
inline constexpr auto to_theirs = [](const dvec3& v) { return theirs::Vector{v.x, v.y, v.z}; };
/// A material at one point. gmis gives directions in world space that point away from the surface;
/// the material wants them in its own frame, the arriving one pointing into the surface.
class Bsdf {
 public:
  using Spectrum = adapter::Spectrum;

  Bsdf(const theirs::Material& material, const theirs::Vector& normal) : material_(&material), basis_(normal) {}
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const dvec3& to_prev, const dvec3& to_next,
                                                   gmis::TransportMode) const {
    const theirs::Vector arriving = basis_.to_local(to_theirs(-to_prev)), leaving = basis_.to_local(to_theirs(to_next));
    if (leaving.z == 0) return {};
    const dvec3 f = ours(material_->value(arriving, leaving)) / std::abs(leaving.z);  // f without the cosine
    const double forward = material_->density(arriving, leaving);
    const double reverse = material_->density(-1 * leaving, -1 * arriving);  // light that takes the way back
    return {f, {{forward}, {reverse}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const dvec3& to_prev, double u,
                                                                    const glm::dvec2& uv,
                                                                    gmis::TransportMode mode) const {
    const auto s = material_->scatter(basis_.to_local(to_theirs(-to_prev)), u, uv.x, uv.y);
    if (!s) return std::nullopt;
    dvec3 weight = ours(s->weight);
    // Their weights are those of power. Radiance scales with the squared index of refraction.
    if (mode == gmis::TransportMode::radiance) weight /= s->index * s->index;
    return gmis::ScatterSample<Spectrum>{
        ours(basis_.to_world(s->leaving)), weight, {{s->density}, {s->density_back}}, s->is_specular, s->index};
  }
  [[nodiscard]] bool is_purely_delta() const { return material_->is_specular(); }
  [[nodiscard]] Spectrum albedo() const { return ours(material_->albedo()); }

 private:
  const theirs::Material* material_;
  theirs::Basis basis_;
};
static_assert(gmis::IsBsdf<Bsdf>());

/// A lamp: points uniform over its area, directions by the cosine.
class Light {
 public:
  using Spectrum = adapter::Spectrum;
  explicit Light(const theirs::Lamp& lamp) : lamp_(&lamp) {}
  [[nodiscard]] bool is_delta() const { return false; }     // rays can hit it
  [[nodiscard]] bool is_infinite() const { return false; }  // it has a position
  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                                 const glm::dvec2& uv) const {
    const Point origin = point_at(uv);
    const dvec3 offset = origin.position - from.position;
    const double distance_squared = glm::dot(offset, offset);
    const dvec3 to_light = offset / std::sqrt(distance_squared);
    const gmis::Emitted<Spectrum> emission = emitted(origin, -to_light);
    if (!(emission.density.first > 0)) return std::nullopt;  // it does not shine this way
    const double cosine = glm::dot(origin.geometric_normal, -to_light);
    const double per_steradian = distance_squared / (cosine * lamp_->area());
    return gmis::NextEventSample<Spectrum>{origin, to_light, emission.radiance / per_steradian, 1 / lamp_->area(),
                                           emission.density};
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const glm::dvec2& uv_origin,
                                                                              const glm::dvec2& uv_direction) const {
    const Point origin = point_at(uv_origin);
    const theirs::Basis basis(to_theirs(origin.geometric_normal));
    const dvec3 direction = ours(basis.to_world(theirs::cosine_hemisphere(uv_direction.x, uv_direction.y)));
    const gmis::Emitted<Spectrum> emission = emitted(origin, direction);
    if (!(emission.density.first > 0)) return std::nullopt;
    // radiance · cos / (origin · first), where first = cos / π
    return gmis::EmissionSample<Spectrum>{origin, direction, emission.radiance * theirs::pi * lamp_->area(),
                                          emission.density};
  }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const dvec3& direction) const {
    const double cosine = glm::dot(origin.geometric_normal, direction);
    if (cosine <= 0) return {};
    return {ours(lamp_->radiance), {1 / lamp_->area(), cosine / theirs::pi}};
  }
  [[nodiscard]] double next_event_density(const Point&, const dvec3&, const Point&) const { return 1 / lamp_->area(); }

 private:
  [[nodiscard]] Point point_at(const glm::dvec2& uv) const {
    const theirs::Shape& shape = lamp_->shape;
    const theirs::Vector at = shape.corner + uv.x * shape.side_a + uv.y * shape.side_b;
    const dvec3 normal = ours(shape.normal_at(at));
    return {ours(at), normal, normal, 1e-9};
  }
  const theirs::Lamp* lamp_;
};
static_assert(gmis::IsLight<Light>());

/// A pinhole. Their rows count from below, those of gmis from above.
class Camera {
 public:
  using Spectrum = adapter::Spectrum;
  explicit Camera(const theirs::Eye& eye) : eye_(&eye) {}
  [[nodiscard]] glm::ivec2 resolution() const { return {eye_->columns, eye_->rows}; }
  [[nodiscard]] bool has_parallel_rays() const { return false; }
  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const glm::dvec2& uv,
                                                                       const glm::dvec2&) const {
    const double x = 2 * (pixel.x + uv.x) / eye_->columns - 1, y = 1 - 2 * (pixel.y + uv.y) / eye_->rows;
    const dvec3 direction =
        ours(theirs::unit(eye_->forward + (x * eye_->half_width) * eye_->right + (y * eye_->half_height) * eye_->up));
    return gmis::CameraSample<Spectrum>{pinhole(), direction, Spectrum(1), density(direction)};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const dvec3& point, const glm::dvec2&) const {
    const dvec3 direction = glm::normalize(point - ours(eye_->position));
    const double depth = glm::dot(direction, ours(eye_->forward));
    if (depth <= 0) return std::nullopt;
    const double x = glm::dot(direction, ours(eye_->right)) / (depth * eye_->half_width);
    const double y = glm::dot(direction, ours(eye_->up)) / (depth * eye_->half_height);
    if (std::abs(x) >= 1 || std::abs(y) >= 1) return std::nullopt;
    const glm::ivec2 pixel(static_cast<int>((x + 1) / 2 * eye_->columns), static_cast<int>((1 - y) / 2 * eye_->rows));
    return gmis::CameraProjection<Spectrum>{pixel, pinhole(), -direction, Spectrum(1), density(direction)};
  }

 private:
  [[nodiscard]] Point pinhole() const { return {ours(eye_->position), {}, {}, 0}; }
  /// Density of the rays of one pixel, per steradian: 1 / (area of the pixel at distance 1 · cos³).
  [[nodiscard]] double density(const dvec3& direction) const {
    const double area = 4 * eye_->half_width * eye_->half_height / (eye_->columns * eye_->rows);
    const double cosine = glm::dot(direction, ours(eye_->forward));
    return 1 / (area * cosine * cosine * cosine);
  }
  const theirs::Eye* eye_;
};
static_assert(gmis::IsCamera<Camera>());
class Scene {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = adapter::Bsdf;
  using Light = adapter::Light;
  using Camera = adapter::Camera;
  explicit Scene(const theirs::World& world) : world_(&world), camera_(world.eye) {
    for (const auto& lamp : world.lamps) lights_.emplace_back(*lamp);
  }
  [[nodiscard]] std::optional<gmis::Hit<double, Bsdf, Light>> intersect(const gmis::Ray<double>& ray) const {
    const auto met = world_->first(to_theirs(ray.origin), to_theirs(ray.direction), ray.t_max);
    if (!met) return std::nullopt;
    const theirs::Vector normal = met->shape->normal_at(met->point);
    const Light* light = nullptr;
    for (std::size_t i = 0; i < lights_.size(); ++i)
      if (world_->lamps[i].get() == met->shape->lamp) light = &lights_[i];
    const Point point{ours(met->point), ours(normal), ours(normal), 1e-9};
    return gmis::Hit<double, Bsdf, Light>{point, Bsdf(*met->shape->material, normal), light};
  }
  [[nodiscard]] bool visible(const gmis::Ray<double>& ray) const {
    return !world_->first(to_theirs(ray.origin), to_theirs(ray.direction), ray.t_max);
  }
  [[nodiscard]] gmis::LightChoice<double, Light> sample_light(double u) const {
    const auto i = static_cast<std::size_t>(u * static_cast<double>(lights_.size()));
    return {&lights_[i], 1.0 / static_cast<double>(lights_.size())};
  }
  [[nodiscard]] double selection_probability(const Light&) const { return 1.0 / static_cast<double>(lights_.size()); }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// Optional: all effects that this renderer can have. Without it gmis assumes every effect.
  [[nodiscard]] gmis::Effects effects() const {
    return {.diffuse = true, .specular_reflection = true, .specular_transmission = true, .area_lights = true};
  }

 private:
  const theirs::World* world_;
  Camera camera_;
  std::vector<Light> lights_;
};
static_assert(gmis::IsScene<Scene>() && gmis::SceneWithEffects<Scene>);

}  // namespace adapter
