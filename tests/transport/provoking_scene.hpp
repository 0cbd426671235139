#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>

#include "transport/furnace_scene.hpp"

namespace gmis_test {

/// The fault of a user's surface or light.
enum class Provocation {
  none,
  mark,         ///< nothing wrong, but what would be is marked: its second channel is halved
  value,        ///< f is `bad`
  mark_sample,  ///< as `mark`, of paths that go on by a sampled direction
  density,      ///< the density of a sampled direction is `bad`
  mark_light,   ///< as `mark`, of sampled light
  light_density,
  seen_light,  ///< a light that is seen has the radiance `bad`, whatever it sends
};

/// The furnace in two channels, of which the second is there to be marked, with the provocation at
/// surface points to the right of an edge. Numbers and densities are those of the furnace whatever
/// is provoked, so a marked run tells what a provoked one must leave out.
class ProvokingScene {
  using Base = FurnaceScene<float>;

 public:
  using Spectrum = glm::vec2;
  static constexpr gmis::Vec2<float> kept{1.0F, 1.0F}, marked{1.0F, 0.5F};

  struct Provoked {
    Provocation what = Provocation::none;
    float bad = 0.0F;
    std::atomic<std::uint64_t>* samples = nullptr;  ///< counts those with a bad density
    float edge = 0.5F;                              ///< surface points with a larger x are provoked
  };

  class Bsdf {
   public:
    using Spectrum = glm::vec2;
    Bsdf() = default;
    Bsdf(const Base::Bsdf& base, const Provoked& provoked) : base_(base), provoked_(provoked) {}
    [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const glm::vec3& to_prev, const glm::vec3& to_next,
                                                     gmis::TransportMode mode) const {
      const auto f = base_.evaluate(to_prev, to_next, mode);
      Spectrum value = f.value * kept;
      if (provoked_.what == Provocation::mark) value = f.value * marked;
      if (provoked_.what == Provocation::value && f.value > 0.0F) value.y = provoked_.bad;
      return {value, f.pdf};
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const glm::vec3& to_prev, float u,
                                                                      const glm::vec2& uv,
                                                                      gmis::TransportMode mode) const {
      const auto s = base_.sample(to_prev, u, uv, mode);
      if (!s) return std::nullopt;
      gmis::ScatterSample<Spectrum> result{s->to_next, s->weight * kept, s->pdf, s->is_delta, s->eta};
      if (provoked_.what == Provocation::mark_sample) result.weight = s->weight * marked;
      if (provoked_.what == Provocation::density) {
        result.pdf.forward.value = provoked_.bad;
        if (provoked_.samples != nullptr) ++*provoked_.samples;
      }
      return result;
    }
    [[nodiscard]] bool is_purely_delta() const { return false; }
    [[nodiscard]] Spectrum albedo() const { return base_.albedo() * kept; }

   private:
    Base::Bsdf base_;
    Provoked provoked_;
  };

  class Light {
   public:
    using Spectrum = glm::vec2;
    Light(const Base::Light& base, const Provoked& provoked) : base_(base), provoked_(provoked) {}
    [[nodiscard]] bool is_delta() const { return false; }
    [[nodiscard]] bool is_infinite() const { return false; }
    [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(
        const gmis::SurfacePoint<float>& from, const glm::vec2& uv) const {
      const auto s = base_.sample_next_event(from, uv);
      if (!s) return std::nullopt;
      gmis::NextEventSample<Spectrum> result{s->origin, s->to_light, s->weight * kept, s->next_event_density,
                                             s->density};
      if (provoked_.what == Provocation::mark_light) result.weight = s->weight * marked;
      if (provoked_.what == Provocation::light_density) result.next_event_density = provoked_.bad;
      return result;
    }
    [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const glm::vec2& uv_origin,
                                                                                const glm::vec2& uv_direction) const {
      const auto s = base_.sample_emission(uv_origin, uv_direction);
      if (!s) return std::nullopt;
      return gmis::EmissionSample<Spectrum>{s->origin, s->direction, s->weight * kept, s->density};
    }
    [[nodiscard]] gmis::Emitted<Spectrum> emitted(const gmis::SurfacePoint<float>& origin,
                                                  const glm::vec3& direction) const {
      const auto e = base_.emitted(origin, direction);
      const bool is_bad = provoked_.what == Provocation::seen_light;
      return {(is_bad ? provoked_.bad : e.radiance) * kept, e.density};
    }
    [[nodiscard]] float next_event_density(const gmis::SurfacePoint<float>& origin, const glm::vec3& direction,
                                           const gmis::SurfacePoint<float>& from) const {
      return base_.next_event_density(origin, direction, from);
    }

   private:
    Base::Light base_;
    Provoked provoked_;
  };

  class Camera {
   public:
    using Spectrum = glm::vec2;
    explicit Camera(int size) : base_(size, {0.2F, 0.1F, 0.0F}) {}
    [[nodiscard]] glm::ivec2 resolution() const { return base_.resolution(); }
    [[nodiscard]] bool has_parallel_rays() const { return false; }
    [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const glm::vec2& uv,
                                                                         const glm::vec2& uv_lens) const {
      const auto s = base_.sample_ray(pixel, uv, uv_lens);
      return gmis::CameraSample<Spectrum>{s->origin, s->direction, s->weight * kept, s->density};
    }
    [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const glm::vec3& point,
                                                                          const glm::vec2& uv_lens) const {
      const auto p = base_.project(point, uv_lens);
      if (!p) return std::nullopt;
      return gmis::CameraProjection<Spectrum>{p->pixel, p->origin, p->to_camera, p->weight * kept, p->density};
    }

   private:
    Base::Camera base_;
  };

  ProvokingScene(int size, const Provoked& provoked, float radiance = 1.0F)
      : base_(0.7F, radiance, size), provoked_(provoked), light_(Base::Light(radiance), provoked), camera_(size) {}

  [[nodiscard]] std::optional<gmis::Hit<float, Bsdf, Light>> intersect(const gmis::Ray<float>& ray) const {
    const auto hit = base_.intersect(ray);
    if (!hit) return std::nullopt;
    const bool is_provoked = hit->point.position.x > provoked_.edge;
    return gmis::Hit<float, Bsdf, Light>{hit->point, Bsdf(hit->bsdf, is_provoked ? provoked_ : Provoked()), &light_};
  }
  [[nodiscard]] bool visible(const gmis::Ray<float>&) const { return true; }
  [[nodiscard]] gmis::LightChoice<float, Light> sample_light(float) const { return {&light_, 1.0F}; }
  [[nodiscard]] float selection_probability(const Light&) const { return 1.0F; }
  [[nodiscard]] std::array<const Light*, 0> infinite_lights() const { return {}; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  Base base_;
  Provoked provoked_;
  Light light_;
  Camera camera_;
};

static_assert(gmis::Scene<ProvokingScene>);

}  // namespace gmis_test
