#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/core/warp.hpp"
// Of a checkout of Tungsten.
#include "bsdfs/Bsdf.hpp"
#include "cameras/PinholeCamera.hpp"
#include "primitives/Primitive.hpp"
#include "renderer/TraceableScene.hpp"
#include "sampling/PathSampleGenerator.hpp"

// Tungsten's intersection, BSDFs, emitters and pinhole camera behind the concepts of gmis. Left
// out: media, surfaces that let light pass straight on, area lights with a texture, filters other
// than a box.

namespace adapter {

using Spectrum = glm::vec3;
using Point = gmis::SurfacePoint<float>;
using glm::vec3, glm::vec2;
using Tungsten::Vec2f, Tungsten::Vec3f;

inline vec3 ours(const Vec3f& v) {
  return {v.x(), v.y(), v.z()};
}
inline Vec3f theirs(const vec3& v) {
  return {v.x, v.y, v.z};
}

/// Hands our numbers to Tungsten's functions: pairs in turn, and one number that choices use up.
class Numbers final : public Tungsten::PathSampleGenerator {
 public:
  Numbers(float u, const vec2& uv) : u_(u), pairs_{uv, uv} {}
  /// The number for choices is what the last digits of a pair say.
  Numbers(const vec2& first, const vec2& second)
      : u_(second.x * 1024 - std::floor(second.x * 1024)), pairs_{first, second} {}

  bool nextBoolean(float probability) override {
    const bool is_true = u_ < probability;
    u_ = below_one(is_true ? u_ / probability : (u_ - probability) / (1 - probability));
    return is_true;
  }
  int nextDiscrete(int count) override {
    const float place = u_ * float(count), chosen = std::floor(place);
    u_ = place - chosen;
    return int(chosen);
  }
  float next1D() override { return u_; }
  Vec2f next2D() override {
    const vec2 pair = pairs_[used_++ % 2];
    return {pair.x, pair.y};
  }
  void startPath(Tungsten::uint32, Tungsten::uint32) override {}
  void advancePath() override {}
  void saveState(Tungsten::OutputStreamHandle&) override {}
  void loadState(Tungsten::InputStreamHandle&) override {}
  Tungsten::UniformSampler& uniformGenerator() override { throw std::logic_error("adapter: no uniform generator"); }

 private:
  static float below_one(float u) { return std::min(u, 0x1.fffffep-1f); }
  float u_;
  vec2 pairs_[2];
  std::size_t used_ = 0;
};

/// Share of the light that a BSDF scatters at a point without a texture, the mean over directions
/// by the cosine, of some drawn ones.
inline vec3 mean_albedo(const Tungsten::Bsdf& bsdf) {
  constexpr int cells = 16;
  Tungsten::IntersectionInfo info{};
  info.Ng = info.Ns = {0, 0, 1};
  vec3 sum(0);
  for (int i = 0; i < cells * cells; ++i) {
    const vec2 place((float(i % cells) + .5f) / cells, (float(i / cells) + .5f) / cells);
    Numbers numbers((float(i * 7 % 256) + .5f) / 256, {place.y, place.x});
    Tungsten::SurfaceScatterEvent at(&info, &numbers, Tungsten::TangentFrame(info.Ns),
                                     theirs(gmis::square_to_cosine_hemisphere(place)),
                                     Tungsten::BsdfLobes(Tungsten::BsdfLobes::AllLobes), false);
    if (bsdf.sample(at)) sum += ours(at.weight);
  }
  return sum / float(cells * cells);
}

class Bsdf {
 public:
  using Spectrum = adapter::Spectrum;
  using Lobes = Tungsten::BsdfLobes;
  using Event = Tungsten::SurfaceScatterEvent;

  /// `to_prev`: of the ray that made the vertex. Tungsten turns the normal of a surface that
  /// reflects only towards it.
  Bsdf(const Tungsten::IntersectionInfo& info, const Tungsten::TangentFrame& frame, const Vec3f& to_prev,
       const vec3* albedo)
      : info_(info), frame_(frame), albedo_(albedo), is_flipped_(reflects_only() && frame.normal.dot(to_prev) < 0) {
    if (is_flipped_) {
      frame_.normal = -frame_.normal;
      frame_.tangent = -frame_.tangent;
    }
  }

  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const vec3& to_prev, const vec3& to_next,
                                                   gmis::TransportMode mode) const {
    gmis::BsdfValue<Spectrum> value = evaluate_forward(to_prev, to_next, mode);
    if (value.pdf.forward.value > 0) value.pdf.reverse = {density(event(to_next, to_prev))};
    return value;
  }
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate_forward(const vec3& to_prev, const vec3& to_next,
                                                           gmis::TransportMode mode) const {
    if (is_purely_delta()) return {};
    Event at = event(to_prev, to_next);
    if (at.wo.z() == 0) return {};
    at.requestedLobe = Lobes(Lobes::AllButSpecular);
    const vec3 value = ours(bsdf().eval(at)) * (scale(at, mode) / std::abs(at.wo.z()));
    return {value, {{density(at)}, {0.f}}};
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const vec3& to_prev, float u, const vec2& uv,
                                                                    gmis::TransportMode mode) const {
    return draw(to_prev, u, uv, mode, true);
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample_forward(const vec3& to_prev, float u,
                                                                            const vec2& uv,
                                                                            gmis::TransportMode mode) const {
    return draw(to_prev, u, uv, mode, false);
  }
  [[nodiscard]] bool is_purely_delta() const { return bsdf().lobes().isPureSpecular(); }
  [[nodiscard]] bool is_glossy() const { return bsdf().lobes().hasGlossy() && !bsdf().lobes().hasDiffuse(); }
  [[nodiscard]] bool has_narrow_lobe() const { return bsdf().lobes().hasGlossy() || bsdf().lobes().hasSpecular(); }
  [[nodiscard]] bool reflects_only() const { return !bsdf().lobes().isTransmissive(); }
  [[nodiscard]] std::uint64_t check_group() const {
    return std::uint64_t(reinterpret_cast<std::uintptr_t>(info_.bsdf));
  }
  [[nodiscard]] Spectrum albedo() const { return albedo_ ? *albedo_ : ours((*bsdf().albedo())[info_]); }

 private:
  [[nodiscard]] const Tungsten::Bsdf& bsdf() const { return *info_.bsdf; }
  [[nodiscard]] Event event(const vec3& to_prev, const vec3& to_next) const {
    Event at(&info_, nullptr, frame_, frame_.toLocal(theirs(to_prev)), Lobes(Lobes::AllLobes), is_flipped_);
    at.wo = frame_.toLocal(theirs(to_next));
    return at;
  }
  /// Theirs scales radiance by the square of the index; importance is not scaled.
  [[nodiscard]] float scale(const Event& at, gmis::TransportMode mode) const {
    const float eta = mode == gmis::TransportMode::radiance ? bsdf().eta(at) : 1.f;
    return eta * eta;
  }
  /// Density of directions that no delta lobe makes. Beside one theirs tells the probability of
  /// that lobe in a cone around it; there the probability of the others is read off outside of the
  /// cone.
  [[nodiscard]] float density(Event at) const {
    at.requestedLobe = Lobes(Lobes::AllLobes);
    if (!bsdf().lobes().hasSpecular()) return bsdf().pdf(at);
    Event without = at;
    without.requestedLobe = Lobes(Lobes::AllButSpecular);
    const float alone = bsdf().pdf(without);
    if (!(alone > 0)) return 0;
    const bool is_beside = std::abs(at.wi.z() * at.wo.z() - at.wi.x() * at.wo.x() - at.wi.y() * at.wo.y() - 1) <
                           Tungsten::DiracAcceptanceThreshold;
    if (!is_beside) return bsdf().pdf(at);
    at.wo = without.wo = Vec3f(at.wo.x() + .1f, at.wo.y(), at.wo.z()).normalized();
    return alone * bsdf().pdf(at) / bsdf().pdf(without);
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> draw(const vec3& to_prev, float u, const vec2& uv,
                                                                  gmis::TransportMode mode, bool with_reverse) const {
    Numbers numbers(u, uv);
    Event at(&info_, &numbers, frame_, frame_.toLocal(theirs(to_prev)), Lobes(Lobes::AllLobes), is_flipped_);
    if (!bsdf().sample(at) || !(at.pdf > 0)) return std::nullopt;
    const bool is_delta = at.sampledLobe.hasSpecular();
    const float reverse = is_delta       ? bsdf().pdf(at.makeFlippedQuery())
                          : with_reverse ? density(at.makeFlippedQuery())
                                         : 0.f;
    return gmis::ScatterSample<Spectrum>{ours(frame_.toGlobal(at.wo)),
                                         ours(at.weight) * scale(at, mode),
                                         {{at.pdf}, {reverse}},
                                         is_delta,
                                         1 / bsdf().eta(at)};
  }

  Tungsten::IntersectionInfo info_;
  Tungsten::TangentFrame frame_;
  const vec3* albedo_;  ///< null where theirs has it
  bool is_flipped_;
};
static_assert(gmis::IsBsdf<Bsdf>());

/// Becomes a `Bsdf` where it is stored.
struct MakeBsdf {
  const Tungsten::IntersectionInfo& info;
  const Tungsten::TangentFrame& frame;
  const Vec3f to_prev;
  const vec3* albedo;
  operator Bsdf() const { return {info, frame, to_prev, albedo}; }
};

/// A primitive that emits: on a surface without a texture, or from infinity.
class Light {
 public:
  using Spectrum = adapter::Spectrum;

  explicit Light(const Tungsten::Primitive& primitive) : primitive_(&primitive) {
    if (is_infinite()) return;
    radiance_ = ours((*primitive.emission())[Vec2f(.5f)]);
    density_ = primitive.positionalPdf(Tungsten::PositionSample());
  }
  [[nodiscard]] const Tungsten::Primitive* primitive() const { return primitive_; }
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] bool is_infinite() const { return primitive_->isInfinite(); }

  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                                 const vec2& uv) const {
    Numbers numbers(uv, uv);
    Tungsten::LightSample drawn;
    const Vec3f position = theirs(from.position);
    if (!primitive_->sampleDirect(0, position, numbers, drawn) || !(drawn.pdf > 0)) return std::nullopt;
    const vec3 to_light = ours(drawn.d);
    if (is_infinite()) {
      const gmis::Emitted<Spectrum> emission = emitted({}, -to_light);
      return gmis::NextEventSample<Spectrum>{{}, to_light, emission.radiance / drawn.pdf, drawn.pdf, emission.density};
    }
    Tungsten::Ray ray(position, drawn.d, 0.f);
    Tungsten::IntersectionTemporary data;
    if (!primitive_->intersect(ray, data)) return std::nullopt;
    Tungsten::IntersectionInfo info;
    info.p = ray.hitpoint();
    info.w = ray.dir();
    primitive_->intersectionInfo(data, info);
    const vec3 normal = ours(info.Ng);
    const Point origin{ours(info.p), normal, normal, 0};
    const gmis::Emitted<Spectrum> emission = emitted(origin, -to_light);
    if (!(emission.density.first > 0)) return std::nullopt;
    const float per_area = drawn.pdf * glm::dot(normal, -to_light) / (ray.farT() * ray.farT());
    return gmis::NextEventSample<Spectrum>{origin, to_light, emission.radiance / drawn.pdf, per_area, emission.density};
  }
  [[nodiscard]] float next_event_density(const Point& origin, const vec3& direction, const Point& from) const {
    Tungsten::IntersectionTemporary data;
    Tungsten::IntersectionInfo info;
    if (is_infinite()) return from_infinity(direction, data, info);
    data.primitive = info.primitive = primitive_;
    info.p = theirs(origin.position);
    info.Ng = info.Ns = theirs(origin.geometric_normal);
    info.w = -theirs(direction);
    const vec3 offset = origin.position - from.position;
    const float per_steradian = primitive_->directPdf(0, data, info, theirs(from.position));
    return per_steradian * std::abs(glm::dot(origin.geometric_normal, direction)) / glm::dot(offset, offset);
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const vec2& uv_origin,
                                                                              const vec2& uv_direction) const {
    Numbers numbers(uv_origin, uv_direction);
    Tungsten::PositionSample point;
    Tungsten::DirectionSample drawn;
    if (!primitive_->samplePosition(numbers, point) || !primitive_->sampleDirection(numbers, point, drawn))
      return std::nullopt;
    const vec3 normal = ours(point.Ng);
    const Point origin = is_infinite() ? Point{ours(point.p), {}, {}, 0} : Point{ours(point.p), normal, normal, 0};
    const auto density = is_infinite() ? gmis::EmissionDensity<float>{drawn.pdf, point.pdf}
                                       : gmis::EmissionDensity<float>{point.pdf, drawn.pdf};
    if (!(density.origin * density.first > 0)) return std::nullopt;
    return gmis::EmissionSample<Spectrum>{origin, ours(drawn.d), ours(point.weight * drawn.weight), density};
  }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const vec3& direction) const {
    if (is_infinite()) {
      Tungsten::IntersectionTemporary data;
      Tungsten::IntersectionInfo info;
      const float of_direction = from_infinity(direction, data, info);
      const Tungsten::PositionSample point({}, theirs(direction));
      return {ours(primitive_->evalDirect(data, info)), {of_direction, primitive_->positionalPdf(point)}};
    }
    const float cosine = glm::dot(origin.geometric_normal, direction);
    if (cosine <= 0) return {};
    return {radiance_, {density_, cosine / gmis::pi<float>}};
  }

 private:
  /// Density of light that comes from infinity in `direction`, per steradian; what theirs knows of
  /// it.
  float from_infinity(const vec3& direction, Tungsten::IntersectionTemporary& data,
                      Tungsten::IntersectionInfo& info) const {
    Tungsten::Ray ray({}, -theirs(direction));
    if (!primitive_->intersect(ray, data)) return 0;
    info.w = ray.dir();
    primitive_->intersectionInfo(data, info);
    return primitive_->directPdf(0, data, info, {});
  }

  const Tungsten::Primitive* primitive_;
  vec3 radiance_{};    ///< of a surface
  float density_ = 0;  ///< of the point on a surface, per area
};
static_assert(gmis::IsLight<Light>());

class Camera {
 public:
  using Spectrum = adapter::Spectrum;

  explicit Camera(const Tungsten::Camera& camera)
      : camera_(&camera), position_(ours(camera.pos())), pixels_(float(camera.resolution().product())) {}
  [[nodiscard]] glm::ivec2 resolution() const { return {camera_->resolution().x(), camera_->resolution().y()}; }
  [[nodiscard]] static constexpr bool has_parallel_rays() { return false; }

  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const vec2& uv,
                                                                       const vec2&) const {
    Numbers numbers(uv, uv);
    Tungsten::DirectionSample drawn;
    const Tungsten::Vec2u place(Tungsten::uint32(pixel.x), Tungsten::uint32(pixel.y));
    if (!camera_->sampleDirection(numbers, {}, place, drawn)) return std::nullopt;
    return gmis::CameraSample<Spectrum>{pinhole(), ours(drawn.d), Spectrum(1), drawn.pdf * pixels_};
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const vec3& at, const vec2& uv_lens) const {
    Numbers numbers(uv_lens, uv_lens);
    const vec3 to_camera = glm::normalize(position_ - at);
    Vec3f weight;
    Vec2f place;
    if (!camera_->evalDirection(numbers, {}, theirs(-to_camera), weight, place)) return std::nullopt;
    const glm::ivec2 pixel(std::floor(place.x()), std::floor(place.y())), size = resolution();
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= size.x || pixel.y >= size.y) return std::nullopt;
    return gmis::CameraProjection<Spectrum>{pixel, pinhole(), to_camera, Spectrum(1), weight.x()};
  }

 private:
  [[nodiscard]] Point pinhole() const { return {position_, {}, {}, 0}; }
  const Tungsten::Camera* camera_;
  vec3 position_;
  float pixels_;
};
static_assert(gmis::IsCamera<Camera>());

class Scene {
 public:
  using Spectrum = adapter::Spectrum;
  using Bsdf = adapter::Bsdf;
  using Light = adapter::Light;
  using Camera = adapter::Camera;

  explicit Scene(Tungsten::TraceableScene& scene) : scene_(&scene), camera_(scene.cam()) {
    for (const auto& light : scene.lights()) {
      light->makeSamplable(scene, 0);
      lights_.emplace_back(*light);
    }
    for (const Light& light : lights_)
      if (light.is_infinite()) infinite_.push_back(&light);
    for (const auto& primitive : scene.primitives())
      if (!primitive->isInfinite()) add(*primitive);
    effects_.environment_lights = !infinite_.empty();
    effects_.area_lights = lights_.size() > infinite_.size();
    effects_.shading_normals = true;
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Tungsten keeps rays off surfaces by the length at which they begin: `position_error` stays 0.
  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    Tungsten::Ray of_theirs(theirs(ray.origin), theirs(ray.direction), epsilon, ray.t_max);
    Tungsten::IntersectionTemporary data;
    Tungsten::IntersectionInfo info;
    if (!scene_->intersect(of_theirs, data, info)) return std::nullopt;
    Tungsten::TangentFrame frame;
    info.primitive->setupTangentFrame(data, info, frame);
    return std::optional<gmis::Hit<float, Bsdf, Light>>(
        std::in_place, Point{ours(info.p), ours(info.Ng), ours(frame.normal), 0},
        MakeBsdf{info, frame, -of_theirs.dir(), albedo_of(*info.bsdf)}, light_of(info.primitive));
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>& ray) const {
    return !scene_->occluded({theirs(ray.origin), theirs(ray.direction), epsilon, (1 - epsilon) * ray.t_max});
  }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float u) const {
    const std::size_t i = std::min(std::size_t(u * float(lights_.size())), lights_.size() - 1);
    return {&lights_[i], 1 / float(lights_.size())};
  }
  [[nodiscard]] float selection_probability(const Light&) const { return 1 / float(lights_.size()); }
  [[nodiscard]] const std::vector<const Light*>& infinite_lights() const { return infinite_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] gmis::Effects effects() const { return effects_; }

 private:
  static constexpr float epsilon = 5e-4f;  // theirs

  [[nodiscard]] const Light* light_of(const Tungsten::Primitive* primitive) const {
    for (const Light& light : lights_)
      if (light.primitive() == primitive) return &light;
    return nullptr;
  }
  [[nodiscard]] const vec3* albedo_of(const Tungsten::Bsdf& bsdf) const {
    if (has_albedo(bsdf)) return nullptr;
    for (const auto& [of, albedo] : albedos_)
      if (of == &bsdf) return &albedo;
    return nullptr;
  }
  /// Theirs names the share of the light that a BSDF scatters: it is diffuse or specular alone.
  [[nodiscard]] static bool has_albedo(const Tungsten::Bsdf& bsdf) {
    return bsdf.lobes().isPureDiffuse() || bsdf.lobes().isPureSpecular();
  }
  void add(Tungsten::Primitive& primitive) {
    for (int i = 0; i < primitive.numBsdfs(); ++i) {
      const Tungsten::Bsdf& bsdf = *primitive.bsdf(i);
      const Tungsten::BsdfLobes lobes = bsdf.lobes();
      if (!has_albedo(bsdf)) albedos_.emplace_back(&bsdf, mean_albedo(bsdf));
      if (lobes.hasForward()) throw std::invalid_argument("adapter: a surface lets light pass straight on");
      effects_.diffuse |= lobes.hasDiffuse();
      effects_.purely_glossy |= lobes.hasGlossy() && !lobes.hasDiffuse();
      effects_.specular_reflection |= lobes.test(Bsdf::Lobes(Bsdf::Lobes::SpecularReflectionLobe));
      effects_.specular_transmission |= lobes.test(Bsdf::Lobes(Bsdf::Lobes::SpecularTransmissionLobe));
      if (lobes.hasGlossy()) effects_.add_glossy_lobe(0);  // how narrow, they do not say
    }
  }

  Tungsten::TraceableScene* scene_;
  Camera camera_;
  std::vector<Light> lights_;
  std::vector<const Light*> infinite_;
  std::vector<std::pair<const Tungsten::Bsdf*, vec3>> albedos_;  ///< where theirs does not name it
  gmis::Effects effects_;
};
static_assert(gmis::IsScene<Scene>() && gmis::SceneWithEffects<Scene>);

}  // namespace adapter
