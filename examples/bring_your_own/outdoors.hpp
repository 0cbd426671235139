#pragma once

#include <array>
#include <cstdint>
#include <gmis/core/warp.hpp>
#include <variant>

#include "adapter.hpp"

/// \file
/// More of an adapter: a sky, a light type that is a lamp or the sky, a leaf that is opaque in
/// places only.

namespace adapter {

/// A sky: light from infinitely far, from all directions above the horizon. It is brighter
/// overhead.
class Sky {
 public:
  using Spectrum = adapter::Spectrum;
  /// `radius`: of a ball around `center` that holds the whole scene.
  Sky(const dvec3& overhead, const dvec3& center, double radius)
      : overhead_(overhead), center_(center), radius_(radius) {}
  [[nodiscard]] bool is_delta() const { return false; }  // rays that leave the scene meet it
  [[nodiscard]] bool is_infinite() const { return true; }
  /// `direction` is the one in which light travels, into the scene: the sky lies towards
  /// −direction.
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point&, const dvec3& direction) const {
    const double height = -direction.y;
    if (height <= 0) return {};
    return {overhead_ * (0.3 + 0.7 * height), density()};
  }
  [[nodiscard]] double next_event_density(const Point&, const dvec3& direction, const Point&) const {
    return direction.y < 0 ? density().origin : 0;
  }
  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point&,
                                                                                 const glm::dvec2& uv) const {
    const dvec3 to_sky = above_horizon(uv);
    const dvec3 radiance = emitted({}, -to_sky).radiance;
    // An infinite light has no point: position and normals stay zero.
    return gmis::NextEventSample<Spectrum>{Point{}, to_sky, radiance / density().origin, density().origin, density()};
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const glm::dvec2& uv_origin,
                                                                              const glm::dvec2& uv_direction) const {
    const dvec3 direction = -above_horizon(uv_direction);
    // A disk across the direction, outside the ball, as wide as the ball.
    const auto frame = gmis::Frame<double>::around(direction);
    const glm::dvec2 place = radius_ * gmis::square_to_disk(uv_origin);
    Point start{};
    start.position = center_ + frame.to_world({place.x, place.y, -radius_});
    const auto [origin, first] = density();
    return gmis::EmissionSample<Spectrum>{
        start, direction, emitted({}, direction).radiance / (origin * first), {origin, first}};
  }

 private:
  /// `origin`: of the direction, per steradian, uniform above the horizon. `first`: of the point on
  /// the disk, per area.
  [[nodiscard]] gmis::EmissionDensity<double> density() const {
    return {1 / (2 * theirs::pi), 1 / (theirs::pi * radius_ * radius_)};
  }
  [[nodiscard]] static dvec3 above_horizon(const glm::dvec2& uv) {
    const dvec3 local = gmis::square_to_cone(uv, 1.0);
    return {local.x, local.z, local.y};  // their y points upwards
  }
  dvec3 overhead_, center_;
  double radius_;
};
static_assert(gmis::IsLight<Sky>());

/// A lamp or the sky: a scene has one type of light.
class LampOrSky {
 public:
  using Spectrum = adapter::Spectrum;
  explicit LampOrSky(const Light& lamp) : which_(lamp) {}
  explicit LampOrSky(const Sky& sky) : which_(sky) {}
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] bool is_infinite() const { return std::holds_alternative<Sky>(which_); }
  [[nodiscard]] auto sample_next_event(const Point& from, const glm::dvec2& uv) const {
    return std::visit([&](const auto& light) { return light.sample_next_event(from, uv); }, which_);
  }
  [[nodiscard]] auto sample_emission(const glm::dvec2& uv_origin, const glm::dvec2& uv_direction) const {
    return std::visit([&](const auto& light) { return light.sample_emission(uv_origin, uv_direction); }, which_);
  }
  [[nodiscard]] auto emitted(const Point& origin, const dvec3& direction) const {
    return std::visit([&](const auto& light) { return light.emitted(origin, direction); }, which_);
  }
  [[nodiscard]] double next_event_density(const Point& origin, const dvec3& direction, const Point& from) const {
    return std::visit([&](const auto& light) { return light.next_event_density(origin, direction, from); }, which_);
  }

 private:
  std::variant<Light, Sky> which_;
};

/// Alpha: opaque in a share of small cells of the surface. The cell of a point decides, so that
/// rays of both kinds of subpath and shadow rays agree about it.
struct Leaf {
  const theirs::Material* material = nullptr;  ///< of the shapes that have holes; none by default
  double alpha = 1;                            ///< share of the surface that is opaque
  int cells = 256;                             ///< along each side

  [[nodiscard]] bool is_opaque(const theirs::World::Meeting& met) const {
    const theirs::Shape& shape = *met.shape;
    if (shape.material.get() != material) return true;
    const dvec3 at = ours(met.point - shape.corner), a = ours(shape.side_a), b = ours(shape.side_b);
    const auto cell = [&](const dvec3& side) {
      return static_cast<std::uint32_t>(std::clamp(glm::dot(at, side) / glm::dot(side, side), 0.0, 1.0) * cells);
    };
    gmis::Philox numbers(0, cell(a), cell(b));  // hashes its arguments
    return gmis::uniform<double>(numbers) < alpha;
  }
};

/// A world outdoors. The last light is the sky.
class OutdoorScene {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = adapter::Bsdf;
  using Light = LampOrSky;
  using Camera = adapter::Camera;
  OutdoorScene(const theirs::World& world, const Sky& sky, const Leaf& leaf)
      : world_(&world), leaf_(leaf), camera_(world.eye) {
    for (const auto& lamp : world.lamps) lights_.emplace_back(adapter::Light(*lamp));
    lights_.emplace_back(sky);
  }
  [[nodiscard]] std::optional<gmis::Hit<double, Bsdf, Light>> intersect(const gmis::Ray<double>& ray) const {
    const auto met = first(ray);
    if (!met) return std::nullopt;  // the engine then asks the infinite lights
    const theirs::Vector normal = met->shape->normal_at(met->point);
    const Light* light = nullptr;
    for (std::size_t i = 0; i < world_->lamps.size(); ++i)
      if (world_->lamps[i].get() == met->shape->lamp) light = &lights_[i];
    const Point point{ours(met->point), ours(normal), ours(normal), 1e-9};
    return gmis::Hit<double, Bsdf, Light>{point, Bsdf(*met->shape->material, normal), light};
  }
  [[nodiscard]] bool visible(const gmis::Ray<double>& ray) const { return !first(ray); }
  [[nodiscard]] gmis::LightChoice<double, Light> sample_light(double u) const {
    const auto i = static_cast<std::size_t>(u * static_cast<double>(lights_.size()));
    return {&lights_[i], 1.0 / static_cast<double>(lights_.size())};
  }
  [[nodiscard]] double selection_probability(const Light&) const { return 1.0 / static_cast<double>(lights_.size()); }
  [[nodiscard]] std::array<const Light*, 1> infinite_lights() const { return {&lights_.back()}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  /// The first shape on the ray that is opaque where the ray meets it.
  [[nodiscard]] std::optional<theirs::World::Meeting> first(gmis::Ray<double> ray) const {
    while (const auto met = world_->first(to_theirs(ray.origin), to_theirs(ray.direction), ray.t_max)) {
      if (leaf_.is_opaque(*met)) return met;
      const double gone = glm::length(ours(met->point) - ray.origin);
      ray = {ours(met->point), ray.direction, ray.t_max - gone};
    }
    return std::nullopt;
  }

  const theirs::World* world_;
  Leaf leaf_;
  Camera camera_;
  std::vector<Light> lights_;
};
static_assert(gmis::IsScene<OutdoorScene>());

}  // namespace adapter
