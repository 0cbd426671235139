#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/core/warp.hpp"
// Of a checkout of lajolla; their names are in the global namespace.
#include "intersection.h"
#include "microfacet.h"
#include "point_and_normal.h"
#include "scene.h"
#include "transform.h"

// lajolla's intersection, materials, lights and camera behind the concepts of gmis. lajolla has a
// path tracer alone: the emission of its lights and the projection on its film are written here.
// Left out: media, and the filtering of textures at the first hit, which would depend on the ray.

namespace adapter {

// Theirs are double: our numbers and vectors are of half the size.
using Spectrum = glm::vec3;
using Point = gmis::SurfacePoint<float>;
using glm::vec3, glm::vec2;

inline vec3 ours(const Vector3& v) {
  return {float(v.x), float(v.y), float(v.z)};
}
inline Vector3 theirs(const vec3& v) {
  return {v.x, v.y, v.z};
}

/// Properties of a material at all its points, whatever its textures say. Their roughness is √α.
struct Traits {
  double least_alpha = 1;
  bool is_diffuse = true;  ///< it has a diffuse part
  bool reflects_only = false;
  bool is_specular = false;     ///< so narrow that the adapter calls it a delta lobe
  double coat_reflectance = 0;  ///< Schlick's, mean over directions by the cosine

  explicit Traits(const Material& material) {
    if (std::holds_alternative<Lambertian>(material)) {
      reflects_only = true;
    } else if (const auto* plastic = std::get_if<RoughPlastic>(&material)) {
      least_alpha = alpha(plastic->roughness);
      reflects_only = true;
      const double head_on = std::pow((plastic->eta - 1) / (plastic->eta + 1), 2);
      coat_reflectance = head_on + (1 - head_on) / 21;
    } else if (const auto* dielectric = std::get_if<RoughDielectric>(&material)) {
      least_alpha = alpha(dielectric->roughness);
      is_diffuse = false;
      is_specular = least_alpha < 1e-3;
    } else {
      least_alpha = 0;  // one of Disney's: anything
    }
  }
  [[nodiscard]] bool is_glossy() const { return least_alpha < 1 && !is_specular; }

 private:
  static double alpha(const Texture1& roughness) {
    const auto* constant = std::get_if<ConstantTexture<Real>>(&roughness);
    if (!constant) return 0;
    const double r = std::clamp(constant->value, .01, 1.);
    return r * r;
  }
};

class Bsdf {
 public:
  using Spectrum = adapter::Spectrum;

  /// `to_prev`: of the ray that made the vertex.
  Bsdf(const ::Scene& scene, const PathVertex& vertex, const Traits& traits, const Vector3& to_prev)
      : scene_(&scene),
        traits_(&traits),
        is_black_(traits.reflects_only && !is_in_front(vertex, to_prev)),
        vertex_(vertex) {}

  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const vec3& to_prev, const vec3& to_next,
                                                   gmis::TransportMode mode) const {
    gmis::BsdfValue<Spectrum> value = evaluate_forward(to_prev, to_next, mode);
    if (value.pdf.forward.value > 0) value.pdf.reverse = {density(theirs(to_next), theirs(to_prev))};
    return value;
  }
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate_forward(const vec3& to_prev, const vec3& to_next,
                                                           gmis::TransportMode mode) const {
    if (traits_->is_specular) return {};
    const Vector3 in = theirs(to_prev), out = theirs(to_next);
    const float cosine = float(std::abs(dot(vertex_.shading_frame.n, out)));
    if (cosine == 0) return {};
    const Vector3 value = eval(material(), in, out, vertex_, scene_->texture_pool, transport(mode));
    return {ours(value) / cosine, {{density(in, out)}, {0.f}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const vec3& to_prev, float u, const vec2& uv,
                                                                    gmis::TransportMode mode) const {
    std::optional<gmis::ScatterSample<Spectrum>> drawn = sample_forward(to_prev, u, uv, mode);
    if (drawn && !drawn->is_delta) drawn->pdf.reverse = {density(theirs(drawn->to_next), theirs(to_prev))};
    return drawn;
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample_forward(const vec3& to_prev, float u,
                                                                            const vec2& uv,
                                                                            gmis::TransportMode mode) const {
    const Vector3 in = theirs(to_prev);
    const auto drawn =
        sample_bsdf(material(), in, vertex_, scene_->texture_pool, Vector2{uv.x, uv.y}, u, transport(mode));
    if (!drawn) return std::nullopt;
    // Theirs keeps a reflection that a microfacet sends through the surface, though no density has
    // it.
    const bool is_reflection = drawn->eta == 0;
    if (is_reflection != (is_in_front(vertex_, in) == is_in_front(vertex_, drawn->dir_out))) return std::nullopt;
    const float forward = density(in, drawn->dir_out);
    if (!(forward > 0)) return std::nullopt;
    const vec3 weight =
        ours(eval(material(), in, drawn->dir_out, vertex_, scene_->texture_pool, transport(mode)) / Real(forward));
    const float eta = is_reflection ? 1.f : float(drawn->eta);
    if (!traits_->is_specular)
      return gmis::ScatterSample<Spectrum>{ours(drawn->dir_out), weight, {{forward}, {0.f}}, false, eta};
    const float chosen = lobe_probability(in, drawn->dir_out, is_reflection, Real(eta));
    return gmis::ScatterSample<Spectrum>{ours(drawn->dir_out), weight, {{chosen}, {chosen}}, true, eta};
  }
  [[nodiscard]] bool is_purely_delta() const { return traits_->is_specular; }
  [[nodiscard]] bool is_glossy() const { return !traits_->is_diffuse && !traits_->is_specular; }
  [[nodiscard]] bool has_narrow_lobe() const { return traits_->least_alpha < gmis::narrow_roughness; }
  [[nodiscard]] bool reflects_only() const { return traits_->reflects_only; }
  [[nodiscard]] std::uint64_t check_group() const { return std::uint64_t(vertex_.material_id); }
  [[nodiscard]] Spectrum albedo() const {
    if (is_black_) return {};
    const auto colour = [this](const TextureSpectrum& texture) {
      return ours(eval(texture, vertex_.uv, vertex_.uv_screen_size, scene_->texture_pool));
    };
    if (const auto* plastic = std::get_if<RoughPlastic>(&material())) {
      const float coated = float(traits_->coat_reflectance), below = (1 - coated) * (1 - coated);
      return colour(plastic->diffuse_reflectance) * below + colour(plastic->specular_reflectance) * coated;
    }
    if (const auto* dielectric = std::get_if<RoughDielectric>(&material()))
      return glm::max(colour(dielectric->specular_reflectance), colour(dielectric->specular_transmittance));
    return colour(get_texture(material()));
  }

 private:
  [[nodiscard]] const Material& material() const { return scene_->materials[std::size_t(vertex_.material_id)]; }
  [[nodiscard]] static bool is_in_front(const PathVertex& vertex, const Vector3& direction) {
    return dot(vertex.geometric_normal, direction) > 0;
  }
  [[nodiscard]] static TransportDirection transport(gmis::TransportMode mode) {
    return mode == gmis::TransportMode::radiance ? TransportDirection::TO_LIGHT : TransportDirection::TO_VIEW;
  }
  [[nodiscard]] float density(const Vector3& in, const Vector3& out) const {
    return float(pdf_sample_bsdf(material(), in, out, vertex_, scene_->texture_pool));
  }

  /// Probability of reflection or refraction at their dielectric: the same for light that takes the
  /// way back.
  [[nodiscard]] float lobe_probability(const Vector3& in, const Vector3& out, bool is_reflection, Real eta) const {
    const Real index = std::get<RoughDielectric>(material()).eta;
    const Vector3 half = normalize(in + out * eta);  // eta is 1 for a reflection
    const Real reflected = fresnel_dielectric(dot(half, in), is_in_front(vertex_, in) ? index : 1 / index);
    return float(is_reflection ? reflected : 1 - reflected);
  }

  const ::Scene* scene_;
  const Traits* traits_;
  bool is_black_;  ///< seen from the back of a surface that only reflects
  PathVertex vertex_;
};
static_assert(gmis::IsBsdf<Bsdf>());

/// Becomes a `Bsdf` where it is stored: theirs, of 232 bytes, is copied once.
struct MakeBsdf {
  const ::Scene& scene;
  const PathVertex& vertex;
  const Traits& traits;
  const Vector3 to_prev;
  operator Bsdf() const { return {scene, vertex, traits, to_prev}; }
};

/// A lamp on a shape, or the environment.
class Light {
 public:
  using Spectrum = adapter::Spectrum;

  Light(const ::Scene& scene, const ::Light& light) : scene_(&scene), light_(&light) {
    if (const auto* lamp = std::get_if<DiffuseAreaLight>(&light)) {
      shape_ = &scene.shapes[std::size_t(lamp->shape_id)];
      mesh_ = std::get_if<TriangleMesh>(shape_);
      radiance_ = ours(lamp->intensity);
      density_ = float(1 / surface_area(*shape_));
    } else {
      density_ = float(1 / (c_PI * scene.bounds.radius * scene.bounds.radius));
    }
  }
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] bool is_infinite() const { return !shape_; }

  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                                 const vec2& uv) const {
    const PointAndNormal drawn = point_for(theirs(from.position), uv);
    const float density = density_of(drawn, from);
    if (!(density > 0)) return std::nullopt;
    const vec3 normal = ours(drawn.normal);
    if (!shape_) {  // theirs keeps the direction in the normal
      const gmis::Emitted<Spectrum> emission = emitted({}, normal);
      return gmis::NextEventSample<Spectrum>{{}, -normal, emission.radiance / density, density, emission.density};
    }
    const Point origin{ours(drawn.position), normal, normal, 0};
    const vec3 offset = origin.position - from.position;
    const float distance_squared = glm::dot(offset, offset);
    const vec3 to_light = offset / std::sqrt(distance_squared);
    const gmis::Emitted<Spectrum> emission = emitted(origin, -to_light);
    if (!(emission.density.first > 0)) return std::nullopt;
    const float per_steradian = density * distance_squared / glm::dot(normal, -to_light);
    return gmis::NextEventSample<Spectrum>{origin, to_light, emission.radiance / per_steradian, density,
                                           emission.density};
  }
  [[nodiscard]] float next_event_density(const Point& origin, const vec3& direction, const Point& from) const {
    return density_of({theirs(origin.position), theirs(shape_ ? origin.geometric_normal : direction)}, from);
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const vec2& uv_origin,
                                                                              const vec2& uv_direction) const {
    if (!shape_) {
      const vec3 direction = ours(point_for({}, uv_origin).normal);
      const auto frame = gmis::Frame<float>::around(direction);
      const float radius = float(scene_->bounds.radius);
      const glm::vec2 place = radius * gmis::square_to_disk(uv_direction);
      const gmis::Emitted<Spectrum> emission = emitted({}, direction);
      const float density = emission.density.origin * emission.density.first;
      if (!(density > 0)) return std::nullopt;
      return gmis::EmissionSample<Spectrum>{
          {ours(scene_->bounds.center) + frame.to_world({place.x, place.y, -radius}), {}, {}, 0},
          direction,
          emission.radiance / density,
          emission.density};
    }
    // For a point inside, theirs samples a sphere uniformly.
    const auto* sphere = std::get_if<Sphere>(shape_);
    const PointAndNormal drawn = point_for(sphere ? sphere->position : Vector3{}, uv_origin);
    const vec3 normal = ours(drawn.normal);
    const Point origin{ours(drawn.position), normal, normal, 0};
    const vec3 direction = gmis::Frame<float>::around(normal).to_world(gmis::square_to_cosine_hemisphere(uv_direction));
    const gmis::Emitted<Spectrum> emission = emitted(origin, direction);
    if (!(emission.density.first > 0)) return std::nullopt;
    return gmis::EmissionSample<Spectrum>{origin, direction, emission.radiance * (gmis::pi<float> / density_),
                                          emission.density};
  }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const vec3& direction) const {
    if (!shape_) {
      const PointAndNormal at{{}, theirs(direction)};
      return {ours(emission(*light_, at.normal, 0, at, *scene_)), {density_of(at, {}), density_}};
    }
    const float cosine = glm::dot(origin.geometric_normal, direction);
    if (cosine <= 0) return {};
    return {radiance_, {density_, cosine / gmis::pi<float>}};
  }

 private:
  /// Density of next events: of a point, per area, or of the direction from the environment, per
  /// steradian.
  [[nodiscard]] float density_of(const PointAndNormal& at, const Point& from) const {
    return mesh_ ? density_ : float(pdf_point_on_light(*light_, at, theirs(from.position), *scene_));
  }
  /// Theirs wants a third number to choose a triangle: the first serves for both.
  [[nodiscard]] PointAndNormal point_for(const Vector3& from, const vec2& uv) const {
    if (!mesh_) return sample_point_on_light(*light_, from, Vector2{uv.x, uv.y}, 0, *scene_);
    const TableDist1D& triangles = mesh_->triangle_sampler;
    const std::size_t i = std::size_t(sample(triangles, uv.x));
    const Real rest = std::clamp((uv.x - triangles.cdf[i]) / triangles.pmf[i], 0., 1.);
    return sample_point_on_light(*light_, from, Vector2{rest, Real(uv.y)}, uv.x, *scene_);
  }

  const ::Scene* scene_;
  const ::Light* light_;
  const Shape* shape_ = nullptr;  ///< null for the environment
  const TriangleMesh* mesh_ = nullptr;
  vec3 radiance_{};  ///< of a lamp
  float density_;    ///< of emission: of the point on the shape, or on the disk across a direction; per area
};
static_assert(gmis::IsLight<Light>());

/// A pinhole with their pixel filter h, from which a ray draws its place on the film. A point that
/// is seen at x belongs to pixel p with the probability h(x − c_p) / Σ h.
class Camera {
 public:
  using Spectrum = adapter::Spectrum;

  explicit Camera(const ::Camera& camera)
      : camera_(&camera),
        position_(ours(xform_point(camera.cam_to_world, {0, 0, 0}))),
        forward_(ours(xform_vector(camera.cam_to_world, {0, 0, 1}))) {
    const Vector3 corner = xform_point(camera.sample_to_cam, {0, 0, 0});
    const Vector3 next = xform_point(camera.sample_to_cam, {1. / camera.width, 1. / camera.height, 0.});
    inverse_area_ = float(1 / std::abs((next.x - corner.x) * (next.y - corner.y)));
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] = exact_sum(double(i) / cells);
  }
  [[nodiscard]] glm::ivec2 resolution() const { return {camera_->width, camera_->height}; }
  [[nodiscard]] static constexpr bool has_parallel_rays() { return false; }
  [[nodiscard]] float filter_radius() const { return float(reach()); }

  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const vec2& uv,
                                                                       const vec2&) const {
    const ::Ray ray = sample_primary(*camera_, {(pixel.x + uv.x) / camera_->width, (pixel.y + uv.y) / camera_->height});
    const vec3 direction = ours(ray.dir);
    const glm::dvec2 x = place(xform_vector(camera_->world_to_cam, ray.dir));
    return gmis::CameraSample<Spectrum>{pinhole(), direction, Spectrum(1),
                                        density(direction) * float(sum(x.x) * sum(x.y))};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const vec3& at, const vec2& uv_lens) const {
    const Vector3 local = xform_point(camera_->world_to_cam, theirs(at));
    if (!(local.z > 0)) return std::nullopt;
    const glm::dvec2 x = place(local), size(resolution()), most = size + reach();
    if (x.x < -reach() || x.y < -reach() || x.x > most.x || x.y > most.y) return std::nullopt;
    const Choice column = pixel_at(x.x, uv_lens.x), row = pixel_at(x.y, uv_lens.y);
    if (column.pixel < 0 || row.pixel < 0 || column.pixel >= camera_->width || row.pixel >= camera_->height)
      return std::nullopt;
    const vec3 to_camera = glm::normalize(position_ - at);
    return gmis::CameraProjection<Spectrum>{{column.pixel, row.pixel},
                                            pinhole(),
                                            to_camera,
                                            Spectrum(1),
                                            density(-to_camera) * float(column.sum * row.sum)};
  }

 private:
  struct Choice {
    int pixel;
    double sum;  ///< of the filters of all pixels
  };
  [[nodiscard]] Choice pixel_at(double x, double u) const {
    const double all = sum(x);
    double left = u * all;
    int pixel = int(std::floor(x - reach()));
    for (const int last = int(std::floor(x + reach())); pixel < last; ++pixel)
      if ((left -= filter(x - (pixel + .5))) < 0) break;
    return {pixel, all};
  }
  /// Sum of the filters of all pixels at x. From a table for a Gaussian, of which the sum is
  /// smooth.
  [[nodiscard]] double sum(double x) const {
    if (!std::holds_alternative<Gaussian>(camera_->filter)) return exact_sum(x);
    const double place = (x - std::floor(x)) * cells;
    const std::size_t i = std::min(std::size_t(place), cells - 1);
    return sums_[i] + (place - double(i)) * (sums_[i + 1] - sums_[i]);
  }
  [[nodiscard]] double exact_sum(double x) const {
    double sum = 0;
    for (int i = int(std::floor(x - reach())); i <= int(std::floor(x + reach())); ++i) sum += filter(x - (i + .5));
    return sum;
  }
  [[nodiscard]] double filter(double x) const {
    if (const auto* gaussian = std::get_if<Gaussian>(&camera_->filter)) {
      const double t = x / gaussian->stddev;
      return std::exp(-t * t / 2) / (gaussian->stddev * std::sqrt(2 * c_PI));
    }
    const double half = reach(), distance = std::abs(x);
    if (distance >= half) return 0;
    return std::holds_alternative<Box>(camera_->filter) ? 1 / (2 * half) : (1 - distance / half) / half;
  }
  [[nodiscard]] double reach() const {
    if (const auto* box = std::get_if<Box>(&camera_->filter)) return box->width / 2;
    if (const auto* tent = std::get_if<Tent>(&camera_->filter)) return tent->width / 2;
    return 6 * std::get<Gaussian>(camera_->filter).stddev;
  }
  /// Place on the film, in pixels, of a direction or a point in the camera's frame.
  [[nodiscard]] glm::dvec2 place(const Vector3& local) const {
    const Vector3 on_film = xform_point(camera_->cam_to_sample, local);
    return {on_film.x * camera_->width, on_film.y * camera_->height};
  }
  [[nodiscard]] Point pinhole() const { return {position_, {}, {}, 0}; }
  /// Density of the rays of one pixel with a box, per steradian.
  [[nodiscard]] float density(const vec3& direction) const {
    const float cosine = glm::dot(direction, forward_);
    return inverse_area_ / (cosine * cosine * cosine);
  }

  const ::Camera* camera_;
  vec3 position_, forward_;
  float inverse_area_;
  static constexpr std::size_t cells = 128;
  std::array<double, cells + 1> sums_;
};
static_assert(gmis::IsCamera<Camera>());

class Scene {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = adapter::Bsdf;
  using Light = adapter::Light;
  using Camera = adapter::Camera;

  explicit Scene(const ::Scene& scene)
      : scene_(&scene), camera_(scene.camera), epsilon_(get_intersection_epsilon(scene)) {
    for (const ::Light& light : scene.lights) lights_.emplace_back(scene, light);
    for (const Light& light : lights_)
      if (light.is_infinite()) infinite_.push_back(&light);
    for (const Material& material : scene.materials) traits_.emplace_back(material);
    for (const Traits& material : traits_) {
      effects_.diffuse |= material.is_diffuse;
      effects_.purely_glossy |= !material.is_diffuse && !material.is_specular;
      effects_.specular_reflection |= material.is_specular;
      if (material.is_glossy()) effects_.add_glossy_lobe(material.least_alpha);
    }
    effects_.specular_transmission = effects_.specular_reflection;
    for (const Shape& shape : scene.shapes) {
      const auto* mesh = std::get_if<TriangleMesh>(&shape);
      effects_.shading_normals |= mesh && !mesh->normals.empty();
    }
    effects_.environment_lights = !infinite_.empty();
    effects_.area_lights = lights_.size() > infinite_.size();
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// lajolla keeps rays off surfaces by the length at which they begin: `position_error` stays 0.
  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    const auto vertex = ::intersect(*scene_, {theirs(ray.origin), theirs(ray.direction), epsilon_, ray.t_max});
    if (!vertex) return std::nullopt;
    const int light = get_area_light_id(scene_->shapes[std::size_t(vertex->shape_id)]);
    return std::optional<gmis::Hit<float, Bsdf, Light>>(
        std::in_place, Point{ours(vertex->position), ours(vertex->geometric_normal), ours(vertex->shading_frame.n), 0},
        MakeBsdf{*scene_, *vertex, traits_[std::size_t(vertex->material_id)], theirs(-ray.direction)},
        light < 0 ? nullptr : &lights_[std::size_t(light)]);
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const {
    return !occluded(*scene_, {theirs(ray.origin), theirs(ray.direction), epsilon_, (1 - epsilon_) * ray.t_max});
  }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const {
    const int i = ::sample_light(*scene_, u);
    return {&lights_[std::size_t(i)], float(light_pmf(*scene_, i))};
  }
  [[nodiscard]] float selection_probability(const Light& light) const {
    return float(light_pmf(*scene_, int(&light - lights_.data())));
  }
  [[nodiscard]] const std::vector<const Light*>& infinite_lights() const { return infinite_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] gmis::Effects effects() const { return effects_; }

 private:
  const ::Scene* scene_;
  Camera camera_;
  double epsilon_;
  std::vector<Light> lights_;
  std::vector<const Light*> infinite_;
  std::vector<Traits> traits_;
  gmis::Effects effects_;
};
static_assert(gmis::IsScene<Scene>() && gmis::SceneWithEffects<Scene>);

}  // namespace adapter
