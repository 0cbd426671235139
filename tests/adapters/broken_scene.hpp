#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/guided_light.hpp"

/// \file
/// A sound scene behind an adapter with one mistake in it, of those that people make.

namespace gmis_test {

enum class Mistake {
  none,
  camera_y_flipped,
  camera_pixel_shifted,
  camera_density_of_picture,
  camera_density_without_cosines,
  camera_one_density_doubled,
  camera_one_weight_doubled,
  camera_direction_not_unit,
  to_camera_reversed,
  normal_turned_to_ray,
  normals_not_unit,
  normal_not_perpendicular,
  shading_normal_reversed,
  hit_beside_ray,
  no_offset,
  t_max_ignored,
  always_visible,
  visible_ignores_t_max,
  hit_without_light,
  infinite_lights_empty,
  selection_probability_wrong,
  choice_states_other_probability,
  receiver_choice_states_other_probability,
  receiver_probability_wrong,
  receiver_probability_of_emission,
  receiver_choice_misses_light,
  densities_with_light_choice,
  next_event_density_with_light_choice,
  next_event_density_doubled,
  next_event_missing,
  emission_missing,
  next_event_weight_with_light_choice,
  next_event_weight_with_cosine,
  next_event_states_other_emission,
  to_light_reversed,
  first_per_area,
  emission_density_doubled,
  emission_origin_doubled,
  emission_weight_without_density,
  emission_direction_not_unit,
  emission_backwards,
  emission_numbers_swapped,
  emission_along_weight_doubled,
  emission_along_missing,
  emitted_radiance_doubled,
  delta_density_zero,
  delta_light_falls_linearly,
  disk_area_halved,
  radiance_negative,
  radiance_infinite,
  next_event_from_behind,
  pdfs_swapped_in_evaluate,
  pdfs_swapped_everywhere,
  cosine_in_f,
  cosine_in_f_and_weight,
  weight_without_cosine,
  weight_without_density,
  weight_negative,
  to_next_not_unit,
  reverse_density_of_sample_doubled,
  pdf_without_lobe_choice,
  pdf_uniform,
  modes_swapped,
  mode_ignored,
  eta_inverted,
  delta_not_flagged,
  purely_delta_wrong,
  delta_reverse_zero,
  delta_probability_one,
  albedo_zero,
  albedo_of_ray,
  to_prev_reversed,
  local_directions,
  reflects_only_wrong,
  forward_density_swapped,
  forward_weight_without_cosine,
  forward_sample_fails,
  count
};

template <class Inner>
class BrokenBsdf {
 public:
  using Spectrum = typename Inner::Spectrum;
  using T = gmis::ScalarOf<Spectrum>;
  /// `direction`: of the ray that found the point.
  BrokenBsdf(const Inner& inner, const gmis::SurfacePoint<T>& point, const gmis::Vec3<T>& direction, Mistake mistake)
      : inner_(inner),
        normal_(point.shading_normal),
        slant_(std::abs(glm::dot(point.shading_normal, direction))),
        mistake_(mistake) {}

  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate(gmis::Vec3<T> to_prev, gmis::Vec3<T> to_next,
                                                   gmis::TransportMode mode) const {
    if (mistake_ == Mistake::to_prev_reversed) to_prev = -to_prev;
    if (mistake_ == Mistake::local_directions) to_next = gmis::Frame<T>::around(normal_).to_world(to_next);
    auto f = inner_.evaluate(to_prev, to_next, mode_of(mode));
    const T cosine = std::abs(glm::dot(normal_, to_next));
    if (mistake_ == Mistake::cosine_in_f || mistake_ == Mistake::cosine_in_f_and_weight) f.value = f.value * cosine;
    if (mistake_ == Mistake::pdfs_swapped_in_evaluate || mistake_ == Mistake::pdfs_swapped_everywhere)
      std::swap(f.pdf.forward, f.pdf.reverse);
    if (mistake_ == Mistake::pdf_uniform && f.pdf.forward.value > T(0))
      f.pdf.forward.value = f.pdf.reverse.value = T(1) / (T(2) * gmis::pi<T>);
    return f;
  }
  [[nodiscard]] gmis::BsdfValue<Spectrum> evaluate_forward(const gmis::Vec3<T>& to_prev, const gmis::Vec3<T>& to_next,
                                                           gmis::TransportMode mode) const {
    auto f = evaluate(to_prev, to_next, mode);
    if (mistake_ == Mistake::forward_density_swapped) f.pdf.forward = f.pdf.reverse;
    return f;
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample_forward(const gmis::Vec3<T>& to_prev, T u,
                                                                            const gmis::Vec2<T>& uv,
                                                                            gmis::TransportMode mode) const {
    auto s = sample(to_prev, u, uv, mode);
    if (mistake_ == Mistake::forward_sample_fails) return std::nullopt;
    if (s && mistake_ == Mistake::forward_weight_without_cosine)
      s->weight = s->weight * (T(1) / std::max(T(0.1), std::abs(glm::dot(normal_, s->to_next))));
    return s;
  }
  [[nodiscard]] std::optional<gmis::ScatterSample<Spectrum>> sample(gmis::Vec3<T> to_prev, T u, gmis::Vec2<T> uv,
                                                                    gmis::TransportMode mode) const {
    if (mistake_ == Mistake::to_prev_reversed) to_prev = -to_prev;
    auto s = inner_.sample(to_prev, u, uv, mode_of(mode));
    if (!s) return s;
    const T cosine = std::abs(glm::dot(normal_, s->to_next));
    switch (mistake_) {
      case Mistake::pdfs_swapped_everywhere:
        if (!s->is_delta) std::swap(s->pdf.forward, s->pdf.reverse);
        break;
      case Mistake::cosine_in_f_and_weight:
        if (!s->is_delta) s->weight = s->weight * cosine;
        break;
      case Mistake::weight_without_cosine:
        if (!s->is_delta) s->weight = s->weight * (T(1) / cosine);
        break;
      case Mistake::weight_without_density:
        if (!s->is_delta) s->weight = s->weight * s->pdf.forward.value;
        break;
      case Mistake::weight_negative:
        s->weight = s->weight * T(-1);
        break;
      case Mistake::to_next_not_unit:
        s->to_next *= T(1.5);
        break;
      case Mistake::reverse_density_of_sample_doubled:
        if (!s->is_delta) s->pdf.reverse.value *= T(2);
        break;
      case Mistake::pdf_without_lobe_choice:
        if (!s->is_delta) s->pdf.forward.value *= T(2);
        break;
      case Mistake::pdf_uniform:
        if (!s->is_delta) s->pdf.forward.value = s->pdf.reverse.value = T(1) / (T(2) * gmis::pi<T>);
        break;
      case Mistake::eta_inverted:
        s->eta = T(1) / s->eta;
        break;
      case Mistake::delta_not_flagged:
        s->is_delta = false;
        break;
      case Mistake::delta_reverse_zero:
        if (s->is_delta) s->pdf.reverse.value = T(0);
        break;
      case Mistake::delta_probability_one:
        if (s->is_delta) s->pdf.forward.value = s->pdf.reverse.value = T(1);
        break;
      case Mistake::local_directions:
        s->to_next = gmis::Frame<T>::around(normal_).to_local(s->to_next);
        break;
      default:
        break;
    }
    return s;
  }
  [[nodiscard]] bool is_purely_delta() const {
    return mistake_ == Mistake::purely_delta_wrong ? !inner_.is_purely_delta() : inner_.is_purely_delta();
  }
  [[nodiscard]] bool reflects_only() const {
    return mistake_ == Mistake::reflects_only_wrong || gmis::reflects_only(inner_);
  }
  [[nodiscard]] Spectrum albedo() const {
    if (mistake_ == Mistake::albedo_of_ray) return Spectrum(inner_.albedo()) * (T(0.9) + T(0.1) * slant_);
    return mistake_ == Mistake::albedo_zero ? Spectrum(T(0)) : Spectrum(inner_.albedo());
  }

 private:
  [[nodiscard]] gmis::TransportMode mode_of(gmis::TransportMode mode) const {
    if (mistake_ == Mistake::mode_ignored) return gmis::TransportMode::importance;
    if (mistake_ != Mistake::modes_swapped) return mode;
    return mode == gmis::TransportMode::radiance ? gmis::TransportMode::importance : gmis::TransportMode::radiance;
  }
  Inner inner_;
  gmis::Vec3<T> normal_;
  T slant_;
  Mistake mistake_;
};

template <class Inner>
class BrokenLight {
 public:
  using Spectrum = typename Inner::Spectrum;
  using T = gmis::ScalarOf<Spectrum>;
  using Point = gmis::SurfacePoint<T>;
  BrokenLight(const Inner& inner, T choice, Mistake mistake) : inner_(inner), choice_(choice), mistake_(mistake) {}

  [[nodiscard]] bool is_delta() const { return inner_.is_delta(); }
  [[nodiscard]] bool is_infinite() const { return inner_.is_infinite(); }
  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> sample_next_event(const Point& from,
                                                                                 const gmis::Vec2<T>& uv) const {
    auto s = inner_.sample_next_event(from, uv);
    if (mistake_ == Mistake::next_event_from_behind && (!s || gmis::is_black(s->weight)) && !is_infinite())
      s = from_behind(from, uv);
    if (!s) return s;
    s->weight = changed(s->weight);
    if (mistake_ == Mistake::next_event_missing && !is_delta() && !is_infinite()) return std::nullopt;
    s->next_event_density *= next_event_factor();
    s->density = changed(s->density);
    if (mistake_ == Mistake::next_event_weight_with_light_choice) s->weight = s->weight * (T(1) / choice_);
    if (mistake_ == Mistake::next_event_weight_with_cosine) s->weight = s->weight * std::abs(s->to_light.y);
    if (mistake_ == Mistake::next_event_states_other_emission && !is_delta()) s->density.first *= T(2);
    if (mistake_ == Mistake::to_light_reversed) s->to_light = -s->to_light;
    if (mistake_ == Mistake::delta_density_zero && is_delta()) s->next_event_density = T(0);
    if (mistake_ == Mistake::delta_light_falls_linearly && is_delta() && !is_infinite())
      s->weight = s->weight * glm::length(s->origin.position - from.position);
    return s;
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> sample_emission(const gmis::Vec2<T>& uv_origin,
                                                                              const gmis::Vec2<T>& uv_direction) const {
    const bool is_swapped = mistake_ == Mistake::emission_numbers_swapped;
    return altered(
        inner_.sample_emission(is_swapped ? uv_direction : uv_origin, is_swapped ? uv_origin : uv_direction));
  }
  [[nodiscard]] auto start_numbers(const Point& origin,
                                   const gmis::Vec3<T>& direction) const requires gmis::GuidableLight<Inner> {
    return inner_.start_numbers(origin, direction);
  }
  [[nodiscard]] auto emission_along(const Point& origin,
                                    const gmis::Vec3<T>& direction) const requires gmis::GuidableLight<Inner> {
    auto s = altered(inner_.emission_along(origin, direction));
    if (s && mistake_ == Mistake::emission_along_weight_doubled) s->weight = s->weight * T(2);
    if (mistake_ == Mistake::emission_along_missing && is_infinite()) return decltype(s){};
    return s;
  }
  [[nodiscard]] gmis::Emitted<Spectrum> emitted(const Point& origin, const gmis::Vec3<T>& direction) const {
    auto e = inner_.emitted(origin, direction);
    e.density = changed(e.density);
    e.radiance = changed(e.radiance);
    if (mistake_ == Mistake::emitted_radiance_doubled) e.radiance = e.radiance * T(2);
    return e;
  }
  [[nodiscard]] T next_event_density(const Point& origin, const gmis::Vec3<T>& direction, const Point& from) const {
    return inner_.next_event_density(origin, direction, from) * next_event_factor();
  }

 private:
  [[nodiscard]] T next_event_factor() const {
    if (mistake_ == Mistake::next_event_density_doubled) return T(2);
    if (mistake_ == Mistake::next_event_density_with_light_choice || mistake_ == Mistake::densities_with_light_choice)
      return choice_;
    return T(1);
  }
  /// The next event of the mirror image of `from` before the lamp.
  [[nodiscard]] std::optional<gmis::NextEventSample<Spectrum>> from_behind(const Point& from,
                                                                           const gmis::Vec2<T>& uv) const {
    const auto start = inner_.sample_emission(uv, uv);
    if (!start) return std::nullopt;
    const gmis::Vec3<T> normal = start->origin.geometric_normal;
    Point before = from;
    before.position -= T(2) * glm::dot(from.position - start->origin.position, normal) * normal;
    auto s = inner_.sample_next_event(before, uv);
    if (s) s->to_light = glm::normalize(s->origin.position - from.position);
    return s;
  }
  [[nodiscard]] std::optional<gmis::EmissionSample<Spectrum>> altered(
      std::optional<gmis::EmissionSample<Spectrum>> s) const {
    if (!s) return s;
    if (mistake_ == Mistake::emission_missing && !is_delta() && !is_infinite()) return std::nullopt;
    s->density = changed(s->density);
    s->weight = changed(s->weight);
    if (mistake_ == Mistake::emission_density_doubled) s->density.first *= T(2);
    if (mistake_ == Mistake::emission_weight_without_density) s->weight = s->weight * s->density.first;
    if (mistake_ == Mistake::emission_direction_not_unit) s->direction *= T(1.5);
    if (mistake_ == Mistake::emission_backwards) s->direction = -s->direction;
    return s;
  }
  [[nodiscard]] Spectrum changed(const Spectrum& light) const {
    if (mistake_ == Mistake::radiance_negative) return light * T(-1);
    if (mistake_ == Mistake::radiance_infinite) return light * std::numeric_limits<T>::infinity();
    return light;
  }
  [[nodiscard]] gmis::EmissionDensity<T> changed(gmis::EmissionDensity<T> density) const {
    if (mistake_ == Mistake::densities_with_light_choice) density.origin *= choice_;
    if (mistake_ == Mistake::emission_origin_doubled && !is_delta()) density.origin *= T(2);
    if (mistake_ == Mistake::first_per_area) density.first *= density.origin;
    if (mistake_ == Mistake::disk_area_halved && is_infinite()) density.first *= T(2);
    return density;
  }
  const Inner& inner_;
  T choice_;
  Mistake mistake_;
};

template <class Inner>
class BrokenCamera {
 public:
  using Spectrum = typename Inner::Spectrum;
  using T = gmis::ScalarOf<Spectrum>;
  BrokenCamera(const Inner& inner, Mistake mistake) : inner_(inner), mistake_(mistake) {}

  [[nodiscard]] glm::ivec2 resolution() const { return inner_.resolution(); }
  [[nodiscard]] bool has_parallel_rays() const { return inner_.has_parallel_rays(); }
  [[nodiscard]] std::optional<gmis::CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const gmis::Vec2<T>& uv,
                                                                       const gmis::Vec2<T>& lens) const {
    auto s = inner_.sample_ray(pixel, uv, lens);
    if (!s) return s;
    s->density *= factor(s->direction);
    if (mistake_ == Mistake::camera_direction_not_unit) s->direction *= T(1.5);
    return s;
  }
  [[nodiscard]] std::optional<gmis::CameraProjection<Spectrum>> project(const gmis::Vec3<T>& point,
                                                                        const gmis::Vec2<T>& lens) const {
    auto p = inner_.project(point, lens);
    if (!p) return p;
    p->density *= factor(p->to_camera);
    if (mistake_ == Mistake::camera_y_flipped) p->pixel.y = resolution().y - 1 - p->pixel.y;
    if (mistake_ == Mistake::camera_pixel_shifted) p->pixel.x = std::min(p->pixel.x + 1, resolution().x - 1);
    if (mistake_ == Mistake::camera_one_density_doubled) p->density *= T(2);
    if (mistake_ == Mistake::camera_one_weight_doubled) p->weight = p->weight * T(2);
    if (mistake_ == Mistake::to_camera_reversed) p->to_camera = -p->to_camera;
    return p;
  }

 private:
  [[nodiscard]] T factor(const gmis::Vec3<T>& direction) const {
    if (mistake_ == Mistake::camera_density_of_picture) return T(1) / static_cast<T>(resolution().x * resolution().y);
    if (mistake_ != Mistake::camera_density_without_cosines) return T(1);
    const auto middle = inner_.sample_ray(resolution() / 2, {T(0), T(0)}, {T(0.5), T(0.5)});
    const T cosine = std::abs(glm::dot(glm::normalize(middle->direction), direction));
    return cosine * cosine * cosine;
  }
  const Inner& inner_;
  Mistake mistake_;
};

template <gmis::Scene Inner>
class BrokenScene {
 public:
  using Spectrum = typename Inner::Spectrum;
  using T = gmis::ScalarOf<Spectrum>;
  using Bsdf = BrokenBsdf<typename Inner::Bsdf>;
  using Light = BrokenLight<typename Inner::Light>;
  using Camera = BrokenCamera<typename Inner::Camera>;

  BrokenScene(const Inner& inner, Mistake mistake)
      : inner_(inner), mistake_(mistake), camera_(inner.camera(), mistake) {
    for (const auto* light : inner.infinite_lights()) infinite_.push_back(adapted(*light));
    if (mistake == Mistake::infinite_lights_empty) infinite_.clear();
    for (int i = 0; i < 4096; ++i) {
      const auto choice = inner.sample_light((static_cast<T>(i) + T(0.5)) / T(4096));
      if (choice.light != nullptr && std::find(known_.begin(), known_.end(), choice.light) == known_.end())
        known_.push_back(choice.light);
    }
    std::stable_sort(known_.begin(), known_.end(), [&](const auto* a, const auto* b) {
      return inner.selection_probability(*a) > inner.selection_probability(*b);
    });
  }
  BrokenScene(const BrokenScene&) = delete;
  BrokenScene& operator=(const BrokenScene&) = delete;

  [[nodiscard]] std::optional<gmis::Hit<T, Bsdf, Light>> intersect(gmis::Ray<T> ray) const {
    if (mistake_ == Mistake::t_max_ignored) ray.t_max = std::numeric_limits<T>::infinity();
    const auto hit = inner_.intersect(ray);
    if (!hit) return std::nullopt;
    auto point = hit->point;
    switch (mistake_) {
      case Mistake::normal_turned_to_ray:
        if (glm::dot(ray.direction, point.geometric_normal) > T(0)) {
          point.geometric_normal = -point.geometric_normal;
          point.shading_normal = -point.shading_normal;
        }
        break;
      case Mistake::normals_not_unit:
        point.geometric_normal *= T(3);
        point.shading_normal *= T(3);
        break;
      case Mistake::normal_not_perpendicular: {
        const auto frame = gmis::Frame<T>::around(point.geometric_normal);
        point.geometric_normal = point.shading_normal = glm::normalize(frame.normal + frame.tangent);
        break;
      }
      case Mistake::shading_normal_reversed:
        point.shading_normal = -point.shading_normal;
        break;
      case Mistake::hit_beside_ray:
        point.position += T(0.02) * glm::length(point.position - ray.origin) *
                          gmis::Frame<T>::around(glm::normalize(ray.direction)).tangent;
        break;
      case Mistake::no_offset:
        point.position_error = T(0);
        break;
      default:
        break;
    }
    const Light* light = hit->light == nullptr ? nullptr : adapted(*hit->light);
    if (mistake_ == Mistake::hit_without_light) light = nullptr;
    return gmis::Hit<T, Bsdf, Light>{point, Bsdf(hit->bsdf, point, ray.direction, mistake_), light};
  }
  [[nodiscard]] bool visible(gmis::Ray<T> ray) const {
    if (mistake_ == Mistake::always_visible) return true;
    if (mistake_ == Mistake::visible_ignores_t_max) ray.t_max = std::numeric_limits<T>::infinity();
    return inner_.visible(ray);
  }
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(T u) const {
    const auto choice = inner_.sample_light(u);
    if (choice.light == nullptr) return {nullptr, T(0)};
    const T wrong =
        mistake_ == Mistake::selection_probability_wrong || mistake_ == Mistake::choice_states_other_probability
            ? T(0.5)
            : T(1);
    return {adapted(*choice.light), choice.selection_probability * wrong};
  }
  [[nodiscard]] T selection_probability(const Light& light) const {
    for (const auto& [inner, own] : lights_)
      if (own.get() == &light)
        return inner_.selection_probability(*inner) *
               (mistake_ == Mistake::selection_probability_wrong ? T(0.5) : T(1));
    return T(0);
  }
  /// The probabilities of the inner scene, changed by place.
  [[nodiscard]] gmis::LightChoice<T, Light> sample_light(const gmis::SurfacePoint<T>& from, T u) const {
    T rest = u;
    for (const auto* light : known_) {
      const T p = probability_at(*light, from);
      if (rest < p) {
        const bool is_wrong = mistake_ == Mistake::receiver_choice_states_other_probability ||
                              mistake_ == Mistake::receiver_probability_wrong;
        return {adapted(*light), p * (is_wrong ? T(0.5) : T(1))};
      }
      rest -= p;
    }
    return {nullptr, T(0)};
  }
  [[nodiscard]] T selection_probability(const Light& light, const gmis::SurfacePoint<T>& from) const {
    if (mistake_ == Mistake::receiver_probability_of_emission) return selection_probability(light);
    for (const auto& [inner, own] : lights_)
      if (own.get() == &light)
        return probability_at(*inner, from) * (mistake_ == Mistake::receiver_probability_wrong ? T(0.5) : T(1));
    return T(0);
  }
  [[nodiscard]] std::span<const Light* const> infinite_lights() const { return infinite_; }
  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  [[nodiscard]] T weight_at(std::size_t i, const gmis::SurfacePoint<T>& from) const {
    if (i == 0 && mistake_ == Mistake::receiver_choice_misses_light) return T(0);
    return inner_.selection_probability(*known_[i]) *
           (T(1) + T(0.8) * std::sin(static_cast<T>(i) * T(2) + from.position.x + from.geometric_normal.y));
  }
  [[nodiscard]] T probability_at(const typename Inner::Light& light, const gmis::SurfacePoint<T>& from) const {
    T own(0), sum(0);
    for (std::size_t i = 0; i < known_.size(); ++i) {
      sum += weight_at(i, from);
      if (known_[i] == &light) own = weight_at(i, from);
    }
    return own > T(0) ? own / sum : T(0);
  }
  [[nodiscard]] const Light* adapted(const typename Inner::Light& light) const {
    auto& own = lights_[&light];
    if (!own) own = std::make_unique<Light>(light, inner_.selection_probability(light), mistake_);
    return own.get();
  }
  const Inner& inner_;
  Mistake mistake_;
  Camera camera_;
  mutable std::map<const typename Inner::Light*, std::unique_ptr<Light>> lights_;
  std::vector<const Light*> infinite_;
  std::vector<const typename Inner::Light*> known_;  ///< those that emission chooses, the most likely one first
};

}  // namespace gmis_test
