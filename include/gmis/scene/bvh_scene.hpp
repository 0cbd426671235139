#pragma once

#include <algorithm>
#include <glm/exponential.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/scene/absorption.hpp"
#include "gmis/scene/alias_table.hpp"
#include "gmis/scene/box.hpp"
#include "gmis/scene/bsdf.hpp"
#include "gmis/scene/bvh.hpp"
#include "gmis/scene/camera.hpp"
#include "gmis/scene/edge_margin.hpp"
#include "gmis/scene/light.hpp"
#include "gmis/scene/light_hierarchy.hpp"
#include "gmis/scene/surface_model.hpp"

namespace gmis::scene {

template <std::floating_point T, SurfaceModel<T> Bsdf_>
class SceneBuilder;

/// Figures of the scene that was built, for reports and for settings that are relative to the size
/// of the scene. Lengths in scene units.
struct SceneStatistics {
  std::size_t triangle_count = 0;             ///< triangles
  std::size_t sphere_count = 0;               ///< spheres
  std::size_t degenerate_triangle_count = 0;  ///< left out: they have no area
  std::size_t light_count = 0;                ///< each triangle of an emitting mesh is one
  std::size_t bvh_bytes = 0;                  ///< nodes and primitives
  double half_diagonal = 0;                   ///< of the bounding box of all surfaces
  double bounding_radius = 0;                 ///< of a ball around them
  glm::dvec3 world_origin{0};                 ///< the point of the world that is 0 in the scene's own space
};

/// The built-in scene: meets `gmis::Scene`. Its space is the world moved so that the camera is at
/// 0, which keeps digits where they are seen. `SceneBuilder` makes it; it can be moved but not
/// copied, since hits point into it.
///
/// `Bsdf_` is how all its surfaces scatter: the built-in materials, a type of yours, or both
/// (`EitherBsdf`).
template <std::floating_point T = float, SurfaceModel<T> Bsdf_ = SurfaceBsdf<T>>
class BvhScene {
 public:
  using Spectrum = Vec3<T>;
  using Bsdf = Bsdf_;
  using Material = typename Bsdf_::Material;
  using Light = scene::Light<T>;
  using Camera = scene::Camera<T>;
  /// The result of `intersect`.
  using Hit = gmis::Hit<T, Bsdf, Light>;

  BvhScene(const BvhScene&) = delete;
  BvhScene& operator=(const BvhScene&) = delete;
  /// Pointers to its lights stay valid.
  BvhScene(BvhScene&&) noexcept = default;
  /// Pointers to its lights stay valid.
  BvhScene& operator=(BvhScene&&) noexcept = default;
  ~BvhScene() = default;

  [[nodiscard]] std::optional<Hit> intersect(const Ray<T>& ray) const noexcept {
    if (has_cut_surfaces_) [[unlikely]]
      return intersect_cut_surfaces(ray);
    const BvhHit<T> found = bvh_.closest(ray);
    switch (found.kind) {
      case BvhChild::triangles:
        return made_in_place([&] { return triangle_hit(found); });
      case BvhChild::spheres:
        return made_in_place([&] { return sphere_hit(found, ray); });
      default:
        return std::nullopt;
    }
  }
  [[nodiscard]] bool visible(const Ray<T>& ray) const noexcept {
    if (has_cut_surfaces_) [[unlikely]]
      return !intersect_cut_surfaces(ray);
    return !bvh_.is_blocked(ray);
  }

  /// True when some material is the boundary of a medium that absorbs.
  [[nodiscard]] bool has_absorption() const noexcept { return has_absorption_; }
  /// Where the ray starts decides in which medium it is; see absorption.hpp.
  [[nodiscard]] GMIS_RARE Spectrum transmittance(const Ray<T>& ray) const noexcept {
    if (std::none_of(absorbing_boxes_.begin(), absorbing_boxes_.end(),
                     [&](const Box<T>& box) { return box.contains(ray.origin); }))
      return Spectrum(T(1));
    const Spectrum sigma = absorption_at(ray);
    if (is_black(sigma)) return Spectrum(T(1));
    return glm::exp(sigma * -ray.t_max);
  }

  [[nodiscard]] LightChoice<T, Light> sample_light(T u) const noexcept {
    if (light_choice_.is_empty()) return {nullptr, T(0)};
    const Light& light = lights_[light_choice_.sample(u)];
    return {&light, light.selection_probability()};
  }
  [[nodiscard]] T selection_probability(const Light& light) const noexcept { return light.selection_probability(); }
  /// For next events: as above, or by the light hierarchy when the builder was told so. Without one
  /// `from` stays in registers: the hierarchy gets a copy.
  [[nodiscard]] LightChoice<T, Light> sample_light(const SurfacePoint<T>& from, T u) const noexcept {
    if (receiver_choice_ != ReceiverChoice::never) [[unlikely]] {
      const SurfacePoint<T> receiver = from;
      const auto choice = light_hierarchy_.sample(receiver, u);
      return {&lights_[choice.light], choice.probability};
    }
    return sample_light(u);
  }
  [[nodiscard]] T selection_probability(const Light& light, const SurfacePoint<T>& from) const noexcept {
    if (receiver_choice_ != ReceiverChoice::never) [[unlikely]] {
      const SurfacePoint<T> receiver = from;
      return light_hierarchy_.probability(static_cast<std::size_t>(&light - lights_.data()), receiver);
    }
    return light.selection_probability();
  }
  /// The runs that use the light hierarchy.
  [[nodiscard]] ReceiverChoice receiver_choice() const noexcept { return receiver_choice_; }
  /// Numbers what a user takes for one light: emitting meshes in the order in which they were
  /// added, then spheres, point, spot and infinite lights. The last group, `most_light_groups` − 1,
  /// holds all that are left.
  [[nodiscard]] std::uint16_t light_group(const Light& light) const noexcept { return light.group(); }
  static constexpr std::uint16_t most_light_groups = 64;  ///< there is a picture for each
  [[nodiscard]] std::span<const Light* const> infinite_lights() const noexcept { return infinite_lights_; }
  /// All lights.
  [[nodiscard]] std::span<const Light> lights() const noexcept { return lights_; }
  [[nodiscard]] const Camera& camera() const noexcept { return camera_; }
  /// Counts and sizes of the scene.
  [[nodiscard]] const SceneStatistics& statistics() const noexcept { return statistics_; }
  /// The effects that the scene has.
  [[nodiscard]] const Effects& effects() const noexcept { return effects_; }

 private:
  friend class SceneBuilder<T, Bsdf_>;

  struct Triangle {
    static constexpr std::uint32_t flat = ~std::uint32_t{0};
    Vec3<T> normal;
    T position_error;
    const Material* material;
    const Light* light;
    std::uint32_t vertex_normals;  ///< the first of three in `vertex_normals_`, or `flat`
    T edge_margin;                 ///< see `largest_edge_margin`
  };
  struct Sphere {
    Vec3<T> center;
    T radius;
    T side;  ///< −1 where the normal points inward
    T position_error;
    const Material* material;
    const Light* light;
  };

  explicit BvhScene(const Camera& camera) : camera_(camera) {}

  /// The hit that `make` returns, made inside of the optional: to move it there would cost its size
  /// in instructions.
  template <class Make>
  [[nodiscard]] static std::optional<Hit> made_in_place(const Make& make) noexcept {
    struct Made {
      const Make& make;
      operator Hit() const noexcept { return make(); }
    };
    return std::optional<Hit>(std::in_place, Made{make});
  }

  [[nodiscard]] Hit triangle_hit(const BvhHit<T>& found) const noexcept {
    const Triangle& triangle = triangles_[found.slot];
    const TrianglePacket<T>& packet = bvh_.triangles[found.slot / lane_count];
    const std::size_t lane = found.slot % lane_count;
    const auto& w = found.corner_weights;
    const T scale = T(1) / (w[0] + w[1] + w[2]);
    T b0 = w[0] * scale, b1 = w[1] * scale, b2 = w[2] * scale;
    if (std::min(b0, std::min(b1, b2)) < triangle.edge_margin) [[unlikely]] {
      const auto corner = [&](std::size_t i) {
        return Vec3<T>(packet.corners[i][0][lane], packet.corners[i][1][lane], packet.corners[i][2][lane]);
      };
      const Vec3<T> moved = keep_off_edges(Vec3<T>(b0, b1, b2), {corner(0), corner(1), corner(2)},
                                           sharp_edges_[found.slot], triangle.position_error);
      b0 = moved.x;
      b1 = moved.y;
      b2 = moved.z;
    }
    // From the corners, not along the ray: this error does not grow with the distance.
    const auto coordinate = [&](std::size_t axis) {
      return b0 * packet.corners[0][axis][lane] + b1 * packet.corners[1][axis][lane] +
             b2 * packet.corners[2][axis][lane];
    };
    const Vec3<T> position(coordinate(0), coordinate(1), coordinate(2));
    Vec3<T> shading_normal = triangle.normal;
    if (triangle.vertex_normals != Triangle::flat) {
      const Vec3<T>* normals = &vertex_normals_[triangle.vertex_normals];
      const Vec3<T> sum = normals[0] * b0 + normals[1] * b1 + normals[2] * b2;
      const T length = glm::length(sum);
      const T side = glm::dot(sum, triangle.normal);
      if (length > T(0) && side != T(0)) shading_normal = sum * (std::copysign(T(1), side) / length);
    }
    if constexpr (VaryingSurfaceModel<Bsdf, T>) {
      if (triangle.material->is_varying) [[unlikely]] {
        return varying_hit(found, {b0, b1, b2}, position, shading_normal);
      }
    }
    return {{position, triangle.normal, shading_normal, triangle.position_error},
            Bsdf(*triangle.material, triangle.normal, shading_normal),
            triangle.light};
  }

  [[nodiscard]] Hit sphere_hit(const BvhHit<T>& found, const Ray<T>& ray) const noexcept {
    const Sphere& sphere = spheres_[found.slot];
    const Vec3<T> outward = glm::normalize((ray.origin - sphere.center) + ray.direction * found.t);
    const Vec3<T> normal = outward * sphere.side;
    if constexpr (VaryingSurfaceModel<Bsdf, T>) {
      if (sphere.material->is_varying) [[unlikely]] {
        return varying_hit(found, outward, normal);
      }
    }
    return {{sphere.center + outward * sphere.radius, normal, normal, sphere.position_error},
            Bsdf(*sphere.material, normal, normal),
            sphere.light};
  }

  /// The coordinates of a triangle's or a sphere's point; only where there are materials that vary.
  [[nodiscard]] SurfaceCoordinates<T> coordinates_at(const BvhHit<T>& found, const Vec3<T>& weights,
                                                     const Vec3<T>& position) const noexcept {
    const TrianglePacket<T>& packet = bvh_.triangles[found.slot / lane_count];
    const std::size_t lane = found.slot % lane_count;
    const auto corner = [&](std::size_t i) {
      return Vec3<T>(packet.corners[i][0][lane], packet.corners[i][1][lane], packet.corners[i][2][lane]);
    };
    auto at = triangle_coordinates<T>(coordinates_[found.slot], {corner(0), corner(1), corner(2)}, weights, position);
    at.set_cell(triangles_[found.slot].position_error);
    return at;
  }
  [[nodiscard]] SurfaceCoordinates<T> coordinates_at(const BvhHit<T>& found, const Vec3<T>& outward) const noexcept {
    const Sphere& sphere = spheres_[found.slot];
    auto at = sphere_coordinates<T>(sphere_axes_[found.slot], sphere.radius, outward,
                                    sphere.center + outward * sphere.radius);
    at.set_cell(sphere.position_error);
    return at;
  }

  /// The hit of a triangle or a sphere whose material varies.
  [[nodiscard]] GMIS_RARE Hit
  varying_hit(const BvhHit<T>& found, const Vec3<T>& weights, const Vec3<T>& position,
              const Vec3<T>& shading_normal) const noexcept requires VaryingSurfaceModel<Bsdf, T> {
    const Triangle& triangle = triangles_[found.slot];
    Bsdf bsdf(*triangle.material, triangle.normal, shading_normal, coordinates_at(found, weights, position));
    const Vec3<T> normal = bsdf.shading_normal();
    return {{position, triangle.normal, normal, triangle.position_error}, std::move(bsdf), triangle.light};
  }
  [[nodiscard]] GMIS_RARE Hit varying_hit(const BvhHit<T>& found, const Vec3<T>& outward,
                                          const Vec3<T>& normal) const noexcept requires VaryingSurfaceModel<Bsdf, T> {
    const Sphere& sphere = spheres_[found.slot];
    Bsdf bsdf(*sphere.material, normal, normal, coordinates_at(found, outward));
    const Vec3<T> shading_normal = bsdf.shading_normal();
    return {{sphere.center + outward * sphere.radius, normal, shading_normal, sphere.position_error},
            std::move(bsdf),
            sphere.light};
  }

  /// σ at the start of the ray: that of the first boundary along it, on this side.
  [[nodiscard]] Spectrum absorption_at(Ray<T> ray) const noexcept {
    ray.t_max = std::numeric_limits<T>::infinity();
    constexpr int most_passed = 1 << 16;
    for (int passed = 0; passed < most_passed; ++passed) {
      const BvhHit<T> found = bvh_.closest(ray);
      if (found.kind == BvhChild::nothing) break;
      const bool is_triangle = found.kind == BvhChild::triangles;
      const Material& material = is_triangle ? *triangles_[found.slot].material : *spheres_[found.slot].material;
      const Hit hit = is_triangle ? triangle_hit(found) : sphere_hit(found, ray);
      if (const Absorption<T>* boundary = boundary_of<T>(material))
        return glm::dot(hit.point.geometric_normal, ray.direction) > T(0) ? boundary->inside : boundary->outside;
      ray.origin = leave(hit.point, ray.direction).origin;
    }
    return Spectrum(T(0));
  }

  /// The nearest hit where there is a surface. Points without one are passed, each from a safe
  /// distance behind it.
  [[nodiscard]] GMIS_RARE std::optional<Hit> intersect_cut_surfaces(Ray<T> ray) const noexcept {
    if constexpr (VaryingSurfaceModel<Bsdf, T>) {
      constexpr int most_passed = 1 << 16;
      for (int passed = 0; passed < most_passed; ++passed) {
        const BvhHit<T> found = bvh_.closest(ray);
        if (found.kind == BvhChild::nothing) return std::nullopt;
        const bool is_triangle = found.kind == BvhChild::triangles;
        const Material& material = is_triangle ? *triangles_[found.slot].material : *spheres_[found.slot].material;
        const Hit hit = is_triangle ? triangle_hit(found) : sphere_hit(found, ray);
        if (!has_opacity(material)) return hit;
        const Vec3<T>& position = hit.point.position;
        const SurfaceCoordinates<T> at =
            is_triangle ? coordinates_at(found, corner_weights_of(found), position)
                        : coordinates_at(found, glm::normalize(position - spheres_[found.slot].center));
        if (!is_cut_away(material, at)) return hit;
        const Ray<T> behind = leave(hit.point, ray.direction);
        ray.t_max -= glm::dot(behind.origin - ray.origin, ray.direction);
        if (!(ray.t_max > T(0))) return std::nullopt;
        ray.origin = behind.origin;
      }
    }
    return std::nullopt;
  }
  [[nodiscard]] static Vec3<T> corner_weights_of(const BvhHit<T>& found) noexcept {
    const auto& w = found.corner_weights;
    return Vec3<T>(w[0], w[1], w[2]) / (w[0] + w[1] + w[2]);
  }

  Bvh<T> bvh_;
  std::vector<Triangle> triangles_;      ///< by slot of the packets
  std::vector<SharpEdges> sharp_edges_;  ///< by slot, too
  std::vector<Sphere> spheres_;
  std::vector<Vec3<T>> vertex_normals_;
  std::vector<TriangleCoordinates<T>> coordinates_;  ///< by slot; empty where nothing varies over the surface
  std::vector<std::array<Vec3<T>, 3>> sphere_axes_;  ///< the same
  std::vector<Material> materials_;
  std::vector<std::shared_ptr<const EnvironmentMap<T>>> environment_maps_;
  std::vector<EmissionPattern<T>> emission_patterns_;
  std::vector<Light> lights_;
  std::vector<const Light*> infinite_lights_;
  AliasTable<T> light_choice_;
  LightHierarchy<T> light_hierarchy_;
  Camera camera_;
  SceneStatistics statistics_;
  Effects effects_;
  std::vector<Box<T>> absorbing_boxes_;  ///< around the surfaces of each material that is a boundary of media
  bool has_cut_surfaces_ = false;        ///< some surface is not everywhere
  ReceiverChoice receiver_choice_ = ReceiverChoice::never;  ///< which runs use the light hierarchy
  bool has_absorption_ = false;
};

static_assert(gmis::SceneWithOptionalReceiverChoice<BvhScene<float>>);
static_assert(gmis::SceneWithEffects<BvhScene<float>>);
static_assert(gmis::SceneWithEffects<BvhScene<double>>);
static_assert(gmis::SceneWithAbsorption<BvhScene<float>>);

}  // namespace gmis::scene
