#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "gmis/core/light_choice.hpp"

/// \file
/// A scene behind a decorator whose members pass their results through functions of a test, which
/// plant a mistake in some of them.

namespace gmis_test {

/// The changes that a mistake makes; a function that is not set changes nothing. Lights are named
/// by their number.
template <gmis::Scene Inner>
struct Alterations {
  using S = typename Inner::Spectrum;
  using T = gmis::ScalarOf<S>;
  using V = gmis::Vec3<T>;
  using Point = gmis::SurfacePoint<T>;
  using Mode = gmis::TransportMode;

  std::function<void(const Point&, const V&, const V&, Mode, gmis::BsdfValue<S>&)> evaluate;  ///< to_prev, to_next
  std::function<void(const Point&, const V&, Mode, gmis::ScatterSample<S>&)> sample;          ///< to_prev
  std::function<void(const Point&, S&)> albedo;
  std::function<void(std::size_t, const Point&, gmis::NextEventSample<S>&)> next_event;
  std::function<void(std::size_t, gmis::EmissionSample<S>&)> emission;
  std::function<void(std::size_t, const Point&, const V&, gmis::Emitted<S>&)> emitted;
  std::function<void(std::size_t, const Point&, const V&, const Point&, T&)> next_event_density;
  std::function<void(const gmis::Ray<T>&, Point&, std::size_t&)> hit;  ///< the last one is the light, if there is one
  std::function<void(const Inner&, gmis::Ray<T>, bool&)> visible;
  std::function<void(std::size_t, T&)> probability;           ///< of emission, as both members state it
  std::function<void(std::size_t, T&)> receiver_probability;  ///< as `selection_probability` states it
  std::function<void(gmis::CameraSample<S>&)> camera_ray;
  std::function<void(gmis::CameraProjection<S>&)> projection;
};

template <gmis::Scene Inner>
class AlteredScene {
 public:
  using Spectrum = typename Inner::Spectrum;
  using T = gmis::ScalarOf<Spectrum>;
  using V = gmis::Vec3<T>;
  using Point = gmis::SurfacePoint<T>;
  using Changes = Alterations<Inner>;

  class Bsdf {
   public:
    using Spectrum = typename Inner::Spectrum;
    Bsdf(const typename Inner::Bsdf& inner, const Point& point, const Changes& changes)
        : inner_(inner), point_(point), changes_(&changes) {}
    [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(const V& to_prev, const V& to_next,
                                                     gmis::TransportMode mode) const {
      auto f = inner_.evaluate(to_prev, to_next, mode);
      if (changes_->evaluate) changes_->evaluate(point_, to_prev, to_next, mode, f);
      return f;
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(const V& to_prev, T u, const gmis::Vec2<T>& uv,
                                                                      gmis::TransportMode mode) const {
      auto s = inner_.sample(to_prev, u, uv, mode);
      if (s && changes_->sample) changes_->sample(point_, to_prev, mode, *s);
      return s;
    }
    [[nodiscard]] bool is_purely_delta() const { return inner_.is_purely_delta(); }
    [[nodiscard]] Spectrum albedo() const {
      Spectrum result = inner_.albedo();
      if (changes_->albedo) changes_->albedo(point_, result);
      return result;
    }

   private:
    typename Inner::Bsdf inner_;
    Point point_;
    const Changes* changes_;
  };

  class Light {
   public:
    using Spectrum = typename Inner::Spectrum;
    Light(const typename Inner::Light& inner, std::size_t number, const Changes& changes)
        : inner_(&inner), number_(number), changes_(&changes) {}
    [[nodiscard]] bool is_delta() const { return inner_->is_delta(); }
    [[nodiscard]] bool is_infinite() const { return inner_->is_infinite(); }
    [[nodiscard]] auto sample_next_event(const Point& from, const gmis::Vec2<T>& uv) const {
      auto s = inner_->sample_next_event(from, uv);
      if (s && changes_->next_event) changes_->next_event(number_, from, *s);
      return s;
    }
    [[nodiscard]] auto sample_emission(const gmis::Vec2<T>& uv_origin, const gmis::Vec2<T>& uv_direction) const {
      auto s = inner_->sample_emission(uv_origin, uv_direction);
      if (s && changes_->emission) changes_->emission(number_, *s);
      return s;
    }
    [[nodiscard]] auto emitted(const Point& origin, const V& direction) const {
      auto e = inner_->emitted(origin, direction);
      if (changes_->emitted) changes_->emitted(number_, origin, direction, e);
      return e;
    }
    [[nodiscard]] T next_event_density(const Point& origin, const V& direction, const Point& from) const {
      T density = inner_->next_event_density(origin, direction, from);
      if (changes_->next_event_density) changes_->next_event_density(number_, origin, direction, from, density);
      return density;
    }
    [[nodiscard]] const typename Inner::Light& inner() const { return *inner_; }
    [[nodiscard]] std::size_t number() const { return number_; }

   private:
    const typename Inner::Light* inner_;
    std::size_t number_;
    const Changes* changes_;
  };

  class Camera {
   public:
    using Spectrum = typename Inner::Spectrum;
    Camera(const typename Inner::Camera& inner, const Changes& changes) : inner_(&inner), changes_(&changes) {}
    [[nodiscard]] glm::ivec2 resolution() const { return inner_->resolution(); }
    [[nodiscard]] bool has_parallel_rays() const { return inner_->has_parallel_rays(); }
    [[nodiscard]] auto sample_ray(glm::ivec2 pixel, const gmis::Vec2<T>& uv, const gmis::Vec2<T>& lens) const {
      auto s = inner_->sample_ray(pixel, uv, lens);
      if (s && changes_->camera_ray) changes_->camera_ray(*s);
      return s;
    }
    [[nodiscard]] auto project(const V& point, const gmis::Vec2<T>& lens) const {
      auto p = inner_->project(point, lens);
      if (p && changes_->projection) changes_->projection(*p);
      return p;
    }

   private:
    const typename Inner::Camera* inner_;
    const Changes* changes_;
  };

  /// Both must outlive this.
  AlteredScene(const Inner& inner, const Changes& changes)
      : inner_(inner), changes_(changes), camera_(inner.camera(), changes) {
    // Every light that emission may choose, in the order of their numbers.
    for (int i = 0; i < 4096; ++i) {
      const auto choice = inner.sample_light((static_cast<T>(i) + T(0.5)) / T(4096));
      if (choice.light != nullptr) adapted(*choice.light);
    }
    for (const auto* light : inner.infinite_lights()) infinite_.push_back(adapted(*light));
  }
  AlteredScene(const AlteredScene&) = delete;
  AlteredScene& operator=(const AlteredScene&) = delete;

  [[nodiscard]] std::optional<gmis::Hit<T, Bsdf, Light>> intersect(const gmis::Ray<T>& ray) const {
    const auto hit = inner_.intersect(ray);
    if (!hit) return std::nullopt;
    Point point = hit->point;
    const Light* light = hit->light == nullptr ? nullptr : adapted(*hit->light);
    std::size_t number = light == nullptr ? 0 : light->number();
    if (changes_.hit) changes_.hit(ray, point, number);
    if (light != nullptr) light = in_order_[number];
    return gmis::Hit<T, Bsdf, Light>{point, Bsdf(hit->bsdf, point, changes_), light};
  }
  [[nodiscard]] bool visible(const gmis::Ray<T>& ray) const {
    bool result = inner_.visible(ray);
    if (changes_.visible) changes_.visible(inner_, ray, result);
    return result;
  }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(T u) const {
    const auto choice = inner_.sample_light(u);
    if (choice.light == nullptr) return {nullptr, T(0)};
    const Light* light = adapted(*choice.light);
    T probability = choice.selection_probability;
    if (changes_.probability) changes_.probability(light->number(), probability);
    return {light, probability};
  }
  [[nodiscard]] T selection_probability(const Light& light) const {
    T probability = inner_.selection_probability(light.inner());
    if (changes_.probability) changes_.probability(light.number(), probability);
    return probability;
  }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(const Point& from,
                                                         T u) const requires gmis::SceneWithReceiverChoice<Inner> {
    const auto choice = inner_.sample_light(from, u);
    if (choice.light == nullptr) return {nullptr, T(0)};
    return {adapted(*choice.light), choice.selection_probability};
  }
  [[nodiscard]] T selection_probability(const Light& light,
                                        const Point& from) const requires gmis::SceneWithReceiverChoice<Inner> {
    T probability = inner_.selection_probability(light.inner(), from);
    if (changes_.receiver_probability) changes_.receiver_probability(light.number(), probability);
    return probability;
  }
  [[nodiscard]] const std::vector<const Light*>& infinite_lights() const { return infinite_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  const Light* adapted(const typename Inner::Light& light) const {
    auto& own = lights_[&light];
    if (!own) {
      own = std::make_unique<Light>(light, in_order_.size(), changes_);
      in_order_.push_back(own.get());
    }
    return own.get();
  }

  const Inner& inner_;
  const Changes& changes_;
  Camera camera_;
  mutable std::map<const typename Inner::Light*, std::unique_ptr<Light>> lights_;
  mutable std::vector<const Light*> in_order_;
  std::vector<const Light*> infinite_;
};

}  // namespace gmis_test
