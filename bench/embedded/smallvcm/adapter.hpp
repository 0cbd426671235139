#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>  // for scene.hxx, as is <string>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bsdf.hxx"
#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/effects.hpp"
#include "scene.hxx"

// SmallVCM's intersection, BSDFs, lights and camera behind the concepts of gmis. The headers *.hxx
// are those of a checkout; their names are in the global namespace.

namespace adapter {

using Spectrum = glm::vec3;
using Point = gmis::SurfacePoint<float>;

inline glm::vec3 to_glm(const Vec3f& v) {
  return {v.x, v.y, v.z};
}
inline Vec3f to_vec3f(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

/// SmallVCM's BSDF keeps the direction that the ray came from: `to_prev` is not read.
class Bsdf {
 public:
  using Spectrum = adapter::Spectrum;
  using Theirs = ::BSDF<false>;  // that of camera paths

  Bsdf(const ::Scene& scene, const Theirs& bsdf, int material) : scene_(&scene), bsdf_(bsdf), material_(material) {}

  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const glm::vec3&, const glm::vec3& to_next,
                                                   gmis::TransportMode) const {
    float cosine, forward, reverse;
    const Vec3f value = bsdf_.Evaluate(*scene_, to_vec3f(to_next), cosine, &forward, &reverse);
    return {to_glm(value), {{forward}, {reverse}}};
  }
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate_forward(const glm::vec3&, const glm::vec3& to_next,
                                                           gmis::TransportMode) const {
    float cosine, forward;
    const Vec3f value = bsdf_.Evaluate(*scene_, to_vec3f(to_next), cosine, &forward);
    return {to_glm(value), {{forward}, {0.f}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::vec3&, float u, const glm::vec2& uv,
                                                                    gmis::TransportMode mode) const {
    return draw<true>(u, uv, mode);
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample_forward(const glm::vec3&, float u,
                                                                            const glm::vec2& uv,
                                                                            gmis::TransportMode mode) const {
    return draw<false>(u, uv, mode);
  }
  [[nodiscard]] bool is_purely_delta() const { return bsdf_.IsDelta(); }
  [[nodiscard]] Spectrum albedo() const { return Spectrum(bsdf_.ContinuationProb()); }

 private:
  template <bool needs_reverse>
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> draw(float u, const glm::vec2& uv,
                                                                  gmis::TransportMode mode) const {
    Vec3f to_next;
    float forward, cosine;
    uint event;
    const Vec3f value = bsdf_.Sample(*scene_, Vec3f(uv.x, uv.y, u), to_next, forward, cosine, &event);
    if (value.IsZero()) return std::nullopt;
    const Vec3f weight = value * (cosine / forward);
    if ((event & Theirs::kSpecular) == 0) {
      const float reverse = needs_reverse ? bsdf_.Pdf(*scene_, to_next, true) : 0.f;
      return gmis::ScatterSample<Spectrum>{to_glm(to_next), to_glm(weight), {{forward}, {reverse}}, false, 1.f};
    }
    float eta = 1.f, scale = 1.f;
    if (event == Theirs::kRefract) {
      const float ior = scene_->GetMaterial(material_).mIOR;
      eta = bsdf_.CosThetaFix() < 0.f ? 1.f / ior : ior;
      // Theirs divides by this square, as radiance changes at refraction; what light subpaths carry
      // does not.
      if (mode == gmis::TransportMode::importance) scale = eta * eta;
    }
    return gmis::ScatterSample<Spectrum>{to_glm(to_next), to_glm(weight * scale), {{forward}, {forward}}, true, eta};
  }

  const ::Scene* scene_;
  Theirs bsdf_;
  int material_;  // theirs is private
};
static_assert(gmis::IsBsdf<Bsdf>());

/// Becomes a `Bsdf` where it is stored: theirs, of 80 bytes, is copied once.
struct MakeBsdf {
  const ::Scene& scene;
  const Bsdf::Theirs& bsdf;
  int material;
  operator Bsdf() const { return {scene, bsdf, material}; }
};

/// One of SmallVCM's lights, with what does not depend on the sample computed once. SmallVCM's
/// densities are products; ours are apart: that of the point and that of the direction, or of the
/// direction and of the point where the light is infinite.
class Light {
 public:
  using Spectrum = adapter::Spectrum;

  Light(const ::Scene& scene, const AbstractLight& light)
      : light_(&light), sphere_(&scene.mSceneSphere), is_delta_(light.IsDelta()), is_infinite_(!light.IsFinite()) {
    if (const auto* area = dynamic_cast<const AreaLight*>(&light)) {
      first_density_ = area->mInvArea;
      second_per_cosine_ = INV_PI_F;
      normal_ = to_glm(area->mFrame.Normal());
    } else if (!is_infinite_) {
      first_density_ = 1.f;
      second_per_cosine_ = UniformSpherePdfW();
    } else {
      first_density_ = is_delta_ ? 1.f : UniformSpherePdfW();
      second_per_cosine_ = ConcentricDiscPdfA() * sphere_->mInvSceneRadiusSqr;
    }
    inverse_first_density_ = 1.f / first_density_;
  }
  [[nodiscard]] bool is_delta() const { return is_delta_; }
  [[nodiscard]] bool is_infinite() const { return is_infinite_; }

  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                                 const glm::vec2& uv) const {
    Vec3f to_light;
    float distance, density, cosine;
    const Vec3f position = to_vec3f(from.position);
    const Vec3f radiance =
        light_->Illuminate(*sphere_, position, Vec2f(uv.x, uv.y), to_light, distance, density, nullptr, &cosine);
    if (radiance.IsZero()) return std::nullopt;
    return gmis::NextEventSample<Spectrum>{{to_glm(position + to_light * distance), normal_, normal_, 0.f},
                                           to_glm(to_light),
                                           to_glm(radiance * (1.f / density)),
                                           first_density_,
                                           {first_density_, cosine * second_per_cosine_}};
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const glm::vec2& uv_origin,
                                                                              const glm::vec2& uv_direction) const {
    Vec3f position, direction;
    float density, first_density, cosine;
    const Vec3f energy = light_->Emit(*sphere_, Vec2f(uv_direction.x, uv_direction.y), Vec2f(uv_origin.x, uv_origin.y),
                                      position, direction, density, &first_density, &cosine);
    return gmis::EmissionSample<Spectrum>{{to_glm(position), normal_, normal_, 0.f},
                                          to_glm(direction),
                                          to_glm(energy * (1.f / density)),
                                          {first_density, cosine * second_per_cosine_}};
  }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const glm::vec3& direction) const {
    float first_density, density;
    const Vec3f radiance =
        light_->GetRadiance(*sphere_, to_vec3f(-direction), to_vec3f(origin.position), &first_density, &density);
    if (radiance.IsZero()) return {};
    return {to_glm(radiance), {first_density, density * inverse_first_density_}};
  }
  [[nodiscard]] float next_event_density(const Point&, const glm::vec3&, const Point&) const { return first_density_; }

 private:
  const AbstractLight* light_;
  const SceneSphere* sphere_;
  bool is_delta_, is_infinite_;
  float first_density_;  // of the point; of the direction where the light is infinite
  float inverse_first_density_;
  float second_per_cosine_;  // of the other; the cosine that SmallVCM states is 1 but for area lights
  glm::vec3 normal_{};
};
static_assert(gmis::IsLight<Light>());

class Camera {
 public:
  using Spectrum = adapter::Spectrum;

  explicit Camera(const ::Camera& camera) : camera_(&camera) {}
  [[nodiscard]] glm::ivec2 resolution() const { return {int(camera_->mResolution.x), int(camera_->mResolution.y)}; }
  [[nodiscard]] static constexpr bool has_parallel_rays() { return false; }
  [[nodiscard]] static constexpr bool has_lens() { return false; }

  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const glm::vec2& uv,
                                                                       const glm::vec2&) const {
    const Ray ray = camera_->GenerateRay(Vec2f(float(pixel.x) + uv.x, float(pixel.y) + uv.y));
    return gmis::CameraSample<Spectrum>{pinhole(), to_glm(ray.dir), Spectrum(1.f),
                                        density(Dot(camera_->mForward, ray.dir))};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const glm::vec3& at, const glm::vec2&) const {
    const Vec3f point = to_vec3f(at);
    const Vec3f to_camera = camera_->mPosition - point;
    const float depth = -Dot(camera_->mForward, to_camera);
    if (depth <= 0.f) return std::nullopt;
    const Vec2f place = camera_->WorldToRaster(point);
    if (!camera_->CheckRaster(place)) return std::nullopt;
    const float inverse_distance = 1.f / std::sqrt(to_camera.LenSqr());
    return gmis::CameraProjection<Spectrum>{{int(place.x), int(place.y)},
                                            pinhole(),
                                            to_glm(to_camera * inverse_distance),
                                            Spectrum(1.f),
                                            density(depth * inverse_distance)};
  }

 private:
  [[nodiscard]] Point pinhole() const { return {to_glm(camera_->mPosition), {}, {}, 0.f}; }
  /// Density of the rays of one pixel, per steradian.
  [[nodiscard]] float density(float cosine) const { return Sqr(camera_->mImagePlaneDist / cosine) / cosine; }

  const ::Camera* camera_;
};
static_assert(gmis::IsCamera<Camera>());

class Scene {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = adapter::Bsdf;
  using Light = adapter::Light;
  using Camera = adapter::Camera;

  explicit Scene(const ::Scene& scene) : scene_(&scene), camera_(scene.mCamera) {
    for (const AbstractLight* light : scene.mLights) lights_.emplace_back(scene, *light);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      if (scene.mLights[i] == scene.mBackground) infinite_.push_back(&lights_[i]);
    }
    first_light_ = lights_.data();
    light_count_ = float(lights_.size());
    last_light_ = int(lights_.size()) - 1;
    light_probability_ = 1.f / light_count_;
    // All four scenes have the same materials.
    effects_.diffuse = true;
    effects_.add_glossy_lobe(std::sqrt(2. / 92.));  // Phong's exponent is 90
    effects_.specular_reflection = effects_.specular_transmission = true;
    for (const AbstractLight* light : scene.mLights) {
      effects_.area_lights |= light->IsFinite() && !light->IsDelta();
      effects_.point_lights |= light->IsFinite() && light->IsDelta();
      effects_.directional_lights |= !light->IsFinite() && light->IsDelta();
      effects_.environment_lights |= !light->IsFinite() && !light->IsDelta();
    }
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// SmallVCM keeps rays off surfaces by moving their origins along them: `position_error` stays 0.
  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& from) const {
    const Vec3f direction = to_vec3f(from.direction);
    const Ray ray(to_vec3f(from.origin) + direction * EPS_RAY, direction, 0.f);
    Isect hit(from.t_max);
    if (!scene_->Intersect(ray, hit)) return std::nullopt;
    const Bsdf::Theirs bsdf(ray, hit, *scene_);
    if (!bsdf.IsValid()) [[unlikely]] {
      return std::nullopt;  // the ray is parallel to the surface
    }
    const glm::vec3 normal = to_glm(hit.normal);
    // Not a variable of this type: g++ 12 fills such a variable with zeros first.
    return std::optional<gmis::Hit<float, Bsdf, Light>>(
        std::in_place, Point{to_glm(ray.org + direction * hit.dist), normal, normal, 0.f},
        MakeBsdf{*scene_, bsdf, hit.matID}, hit.lightID >= 0 ? first_light_ + hit.lightID : nullptr);
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const {
    return !scene_->Occluded(to_vec3f(ray.origin), to_vec3f(ray.direction), ray.t_max);
  }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const {
    return {first_light_ + std::min(int(u * light_count_), last_light_), light_probability_};
  }
  [[nodiscard]] float selection_probability(const Light&) const { return light_probability_; }
  [[nodiscard]] const std::vector<const Light*>& infinite_lights() const { return infinite_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] gmis::Effects effects() const { return effects_; }

 private:
  const ::Scene* scene_;
  Camera camera_;
  std::vector<Light> lights_;
  std::vector<const Light*> infinite_;
  const Light* first_light_;
  float light_count_, light_probability_;
  int last_light_;
  gmis::Effects effects_;
};
static_assert(gmis::IsScene<Scene>() && gmis::SceneWithEffects<Scene>);

}  // namespace adapter
