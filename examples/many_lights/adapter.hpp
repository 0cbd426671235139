#pragma once

#include <array>
#include <gmis/core/effects.hpp>
#include <gmis/core/light_choice.hpp>
#include <gmis/core/warp.hpp>

#include "their_renderer.hpp"

/// \file
/// The adapter: everything that gmis needs to know of the renderer in their_renderer.hpp, its grid
/// of lamps included.

namespace many_lights {

using glm::vec2;
using glm::vec3;
using Point = gmis::SurfacePoint<float>;

/// Diffuse on both sides.
class Bsdf {
 public:
  using Spectrum = vec3;
  Bsdf() = default;
  Bsdf(const vec3& colour, const vec3& normal) : colour_(colour), normal_(normal) {}
  [[nodiscard]] gmis::BsdfValue<vec3> evaluate(const vec3& to_prev, const vec3& to_next, gmis::TransportMode) const {
    const float prev = glm::dot(normal_, to_prev), next = glm::dot(normal_, to_next);
    if (!(prev * next > 0)) return {};
    return {colour_ / gmis::pi<float>, {{std::abs(next) / gmis::pi<float>}, {std::abs(prev) / gmis::pi<float>}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<vec3>> sample(const vec3& to_prev, float, const vec2& uv,
                                                                gmis::TransportMode mode) const {
    const vec3 side = glm::dot(normal_, to_prev) > 0 ? normal_ : -normal_;
    const vec3 to_next = gmis::Frame<float>::around(side).to_world(gmis::square_to_cosine_hemisphere(uv));
    const auto f = evaluate(to_prev, to_next, mode);
    if (!(f.pdf.forward.value > 0)) return std::nullopt;
    return gmis::ScatterSample<vec3>{to_next, colour_, f.pdf, false, 1.0F};
  }
  [[nodiscard]] bool is_purely_delta() const { return false; }
  [[nodiscard]] vec3 albedo() const { return colour_; }
  [[nodiscard]] bool has_narrow_lobe() const { return false; }
  [[nodiscard]] bool reflects_only() const { return true; }

 private:
  vec3 colour_{}, normal_{};
};
static_assert(gmis::Bsdf<Bsdf>);

/// A lamp: points uniform over the ball, directions by the cosine.
class Light {
 public:
  using Spectrum = vec3;
  explicit Light(const town::Lamp& lamp)
      : lamp_(&lamp), density_(1 / (4 * gmis::pi<float> * lamp.radius * lamp.radius)) {}
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] bool is_infinite() const { return false; }
  [[nodiscard]] std::optional<gmis::NextEventSample<vec3>> sample_next_event(const Point& from, const vec2& uv) const {
    const Point origin = point_at(uv);
    const vec3 offset = origin.position - from.position;
    const float distance_squared = glm::dot(offset, offset);
    const vec3 to_light = offset / std::sqrt(distance_squared);
    const gmis::Emitted<vec3> emission = emitted(origin, -to_light);
    if (!(emission.density.first > 0)) return std::nullopt;
    const float per_steradian = density_ * distance_squared / -glm::dot(origin.geometric_normal, to_light);
    return gmis::NextEventSample<vec3>{origin, to_light, emission.radiance / per_steradian, density_, emission.density};
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<vec3>> sample_emission(const vec2& uv_origin,
                                                                          const vec2& uv_direction) const {
    const Point origin = point_at(uv_origin);
    const vec3 direction =
        gmis::Frame<float>::around(origin.geometric_normal).to_world(gmis::square_to_cosine_hemisphere(uv_direction));
    const gmis::Emitted<vec3> emission = emitted(origin, direction);
    if (!(emission.density.first > 0)) return std::nullopt;
    return gmis::EmissionSample<vec3>{origin, direction, emission.radiance * (gmis::pi<float> / density_),
                                      emission.density};
  }
  [[nodiscard]] gmis::Emitted<vec3> emitted(const Point& origin, const vec3& direction) const {
    const float cosine = glm::dot(origin.geometric_normal, direction);
    if (!(cosine > 0)) return {};
    return {lamp_->radiance, {density_, cosine / gmis::pi<float>}};
  }
  [[nodiscard]] float next_event_density(const Point&, const vec3&, const Point&) const { return density_; }

 private:
  [[nodiscard]] Point point_at(const vec2& uv) const {
    const vec3 normal = gmis::square_to_sphere(uv);
    return {lamp_->center + lamp_->radius * normal, normal, normal, 1e-4F};
  }
  const town::Lamp* lamp_;
  float density_;
};
static_assert(gmis::Light<Light>);

class Camera {
 public:
  using Spectrum = vec3;
  explicit Camera(const town::Eye& eye) : eye_(&eye) {}
  [[nodiscard]] glm::ivec2 resolution() const { return {eye_->columns, eye_->rows}; }
  [[nodiscard]] bool has_parallel_rays() const { return false; }
  [[nodiscard]] bool has_lens() const { return false; }
  [[nodiscard]] std::optional<gmis::CameraSample<vec3>> sample_ray(glm::ivec2 pixel, const vec2& uv,
                                                                   const vec2&) const {
    const vec2 at = 2.0F * (vec2(pixel) + uv) / vec2(resolution()) - 1.0F;
    const vec3 way =
        glm::normalize(eye_->forward + at.x * eye_->half_width * eye_->right - at.y * eye_->half_height * eye_->up);
    return gmis::CameraSample<vec3>{pinhole(), way, vec3(1), density(way)};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<vec3>> project(const vec3& point, const vec2&) const {
    const vec3 way = glm::normalize(point - eye_->position);
    const float depth = glm::dot(way, eye_->forward);
    if (!(depth > 0)) return std::nullopt;
    const float x = glm::dot(way, eye_->right) / (depth * eye_->half_width);
    const float y = -glm::dot(way, eye_->up) / (depth * eye_->half_height);
    if (!(std::abs(x) < 1 && std::abs(y) < 1)) return std::nullopt;
    const glm::ivec2 pixel((vec2(x, y) + 1.0F) / 2.0F * vec2(resolution()));
    return gmis::CameraProjection<vec3>{pixel, pinhole(), -way, vec3(1), density(way)};
  }

 private:
  [[nodiscard]] Point pinhole() const { return {eye_->position, {}, {}, 0}; }
  [[nodiscard]] float density(const vec3& way) const {
    const float cosine = glm::dot(way, eye_->forward);
    const float area = 4 * eye_->half_width * eye_->half_height / static_cast<float>(eye_->columns * eye_->rows);
    return 1 / (area * cosine * cosine * cosine);
  }
  const town::Eye* eye_;
};
static_assert(gmis::Camera<Camera>);

/// `uses_grid`: next events choose lamps by the grid; otherwise all lamps are chosen alike.
template <bool uses_grid = true>
class Scene {
 public:
  using Spectrum = vec3;
  using Bsdf = many_lights::Bsdf;
  using Light = many_lights::Light;
  using Camera = many_lights::Camera;
  explicit Scene(const town::Town& town) : town_(&town), camera_(town.eye) {
    for (const town::Lamp& lamp : town.lamps) lights_.emplace_back(lamp);
  }
  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    const auto met = town_->first(ray.origin, ray.direction, ray.t_max);
    if (!met) return std::nullopt;
    const Light* light =
        met->lamp == nullptr ? nullptr : &lights_[static_cast<std::size_t>(met->lamp - &town_->lamps[0])];
    const vec3 at = ray.origin + met->distance * ray.direction;
    return gmis::Hit<float, Bsdf, Light>{{at, met->normal, met->normal, 1e-4F}, Bsdf(met->colour, met->normal), light};
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const {
    return !town_->first(ray.origin, ray.direction, ray.t_max);
  }
  /// For light subpaths: any lamp.
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const {
    const auto i = static_cast<std::size_t>(u * static_cast<float>(lights_.size()));
    return {&lights_[std::min(i, lights_.size() - 1)], selection_probability(lights_[0])};
  }
  [[nodiscard]] float selection_probability(const Light&) const { return 1.0F / static_cast<float>(lights_.size()); }
  /// For next events at `from`: a lamp that matters there.
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(const Point& from, float u) const requires uses_grid {
    const Light& light = lights_[town_->grid.pick(from.position, u)];
    return {&light, selection_probability(light, from)};
  }
  [[nodiscard]] float selection_probability(const Light& light, const Point& from) const requires uses_grid {
    return town_->grid.probability(static_cast<std::size_t>(&light - &lights_[0]), from.position);
  }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] gmis::Effects effects() const { return {.diffuse = true, .area_lights = true}; }

 private:
  const town::Town* town_;
  Camera camera_;
  std::vector<Light> lights_;
};
static_assert(gmis::SceneWithReceiverChoice<Scene<>>);

}  // namespace many_lights
