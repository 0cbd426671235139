#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <span>
#include <vector>

#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

/// Checks one light of a scene: next events, emission and what rays that hit the light find, against each other.
template <Scene Sc, UniformSource Source>
class LightCheck {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;

  /// `receivers`: points that the light may reach, on surfaces or between them. `level`: chance of a false alarm of each
  /// statistical test.
  LightCheck(const Sc& scene, const Light& light, std::span<const Point> receivers, Source& source, double level,
             std::size_t samples)
      : scene_(scene), light_(light), receivers_(receivers), source_(source), level_(level), samples_(samples) {}

  /// Runs all checks of the light.
  [[nodiscard]] Findings run() {
    if (receivers_.empty()) return findings_;
    next_events();
    emissions();
    if (light_.is_delta()) {
      delta_intensity();
    } else {
      const std::size_t tested = std::min<std::size_t>(3, receivers_.size());
      for (std::size_t i = 0; i < tested; ++i) distributions(receivers_[(i * receivers_.size()) / tested]);
      emission_directions();
    }
    if (light_.is_infinite()) emission_disk();
    return findings_;
  }

 private:
  using V = Vec3<double>;
  static constexpr double sphere = 4.0 * pi<double>;

  [[nodiscard]] Vec2<T> two() {
    const T u = uniform<T>(source_);
    return {u, uniform<T>(source_)};
  }
  [[nodiscard]] const Point& receiver() {
    return receivers_[uniform_index(source_, static_cast<std::uint32_t>(receivers_.size()))];
  }
  [[nodiscard]] static double number(const S& s) { return static_cast<double>(mean_channel(s)); }
  [[nodiscard]] static double number(T x) requires(!std::same_as<S, T>) { return static_cast<double>(x); }
  [[nodiscard]] static double cosine(const Vec3<T>& a, const Vec3<T>& b) { return std::abs(glm::dot(V(a), V(b))); }
  [[nodiscard]] Ray<T> towards(const Point& from, const Vec3<T>& direction) const { return leave(from, direction); }

  /// The samples of next events against `next_event_density`, `emitted` and what a ray finds.
  void next_events() {
    for (std::size_t i = 0; i < 512; ++i) {
      const Point& from = receiver();
      const auto sample = light_.sample_next_event(from, two());
      if (!sample || is_black(sample->weight)) continue;
      const V offset = V(sample->origin.position) - V(from.position);
      const double distance = glm::length(offset);
      const bool is_toward = light_.is_infinite() || glm::length(offset / distance - V(sample->to_light)) < 0.01;
      findings_.count(Convention::next_event_direction,
                      is_toward && detail::nearly(glm::length(V(sample->to_light)), 1.0, 1e-3));
      if (!is_toward) continue;
      const double density = number(sample->next_event_density);
      if (light_.is_delta()) {
        findings_.count(Convention::light_delta_densities, detail::nearly(density, 1.0, 1e-3));
        findings_.count(Convention::light_delta_densities, detail::nearly(number(sample->density.origin), 1.0, 1e-3));
        continue;
      }
      findings_.count(
          Convention::next_event_two_densities,
          detail::nearly(density, number(light_.next_event_density(sample->origin, -sample->to_light, from))));
      const auto emitted = light_.emitted(sample->origin, -sample->to_light);
      const double cos_light = light_.is_infinite() ? 1.0 : cosine(sample->origin.geometric_normal, sample->to_light);
      if (cos_light < 0.05) continue;  // ruled by the rounding of the direction
      findings_.count(Convention::next_event_emission_density,
                      detail::nearly(number(sample->density.origin), number(emitted.density.origin)) &&
                          detail::nearly(number(sample->density.first), number(emitted.density.first)));
      const double geometry = light_.is_infinite() ? 1.0 : cos_light / (distance * distance);
      findings_.count(Convention::next_event_weight,
                      detail::nearly(number(sample->weight), number(emitted.radiance) * geometry / density, 0.02));
      if (light_.is_infinite() || !scene_.visible(segment(from, sample->origin, sample->to_light))) continue;
      const auto hit = scene_.intersect(towards(from, sample->to_light));
      findings_.count(Convention::light_not_hit,
                      hit && hit->light == &light_ &&
                          glm::length(V(hit->point.position) - V(sample->origin.position)) < 0.01 * distance);
    }
  }

  /// The samples of emission against `emitted`.
  void emissions() {
    for (std::size_t i = 0; i < 512; ++i) {
      const auto sample = light_.sample_emission(two(), two());
      if (!sample || is_black(sample->weight)) continue;
      const bool is_surface = !light_.is_infinite() && !light_.is_delta();
      const double cos_light = is_surface ? glm::dot(V(sample->origin.geometric_normal), V(sample->direction)) : 1.0;
      findings_.count(Convention::emission_unit, detail::nearly(glm::length(V(sample->direction)), 1.0, 1e-3));
      if (light_.is_delta()) {
        findings_.count(Convention::light_delta_densities, detail::nearly(number(sample->density.origin), 1.0, 1e-3));
        continue;
      }
      if (std::abs(cos_light) < 0.05) continue;  // ruled by the rounding of the direction
      const auto emitted = light_.emitted(sample->origin, sample->direction);
      const double origin = number(sample->density.origin), first = number(sample->density.first);
      findings_.count(Convention::emission_two_densities, detail::nearly(origin, number(emitted.density.origin)) &&
                                                              detail::nearly(first, number(emitted.density.first)));
      findings_.count(Convention::emission_weight,
                      detail::nearly(number(sample->weight) * origin * first,
                                     number(emitted.radiance) * std::abs(cos_light), 0.02));
    }
  }

  /// Emission of a delta light against its next events.
  void delta_intensity() {
    const double reach = glm::length(V(receivers_.front().position)) + 1.0;
    for (std::size_t i = 0; i < 256; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (!start || is_black(start->weight)) continue;
      // A point that the light reaches along this direction.
      const double distance = reach * (0.5 + uniform<double>(source_));
      Point from{};
      from.position = Vec3<T>(V(start->origin.position) + distance * V(start->direction));
      const auto sample = light_.sample_next_event(from, two());
      if (!sample) {
        findings_.count(Convention::emission_intensity, false);
        continue;
      }
      const double sent = number(start->weight) * number(start->density.first);
      const double arrives = number(sample->weight) * (light_.is_infinite() ? 1.0 : distance * distance);
      findings_.count(Convention::emission_intensity, detail::nearly(sent, arrives, 0.02) &&
                                                          glm::dot(V(sample->to_light), V(start->direction)) < -0.99);
      findings_.count(Convention::next_event_emission_density,
                      detail::nearly(number(sample->density.first), number(start->density.first), 0.02));
    }
    if (light_.is_infinite()) return;
    // `first` as next events state it, over all directions.
    DirectionSet directions(*this);
    const auto center = light_.sample_emission(two(), two());
    if (!center) return;
    const auto density = [&](const V& direction) {
      Point from{};
      from.position = Vec3<T>(V(center->origin.position) + reach * direction);
      const auto sample = light_.sample_next_event(from, {T(0.5), T(0.5)});
      return sample ? number(sample->density.first) : 0.0;
    };
    for (std::size_t i = 0; i < samples_; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (start)
        directions.add_sample(density(V(start->direction)), V(start->direction));
      else
        directions.add_failure();
      const V any = directions.draw();
      directions.add_known(density(any), any);
    }
    findings_.judge(Convention::emission_direction_distribution, directions.passes());
  }

  /// Uniform directions over the sphere beside those of a sampler.
  struct DirectionSet {
    explicit DirectionSet(LightCheck& check_in) : check(check_in) {}
    [[nodiscard]] V draw() {
      const double u = uniform<double>(check.source_);
      return V(square_to_sphere(Vec2<double>(u, uniform<double>(check.source_))));
    }
    void add_failure() { test.add_sample(0.0, 1.0 / sphere, 0.0); }
    void add_sample(double density, const V& direction) { test.add_sample(density, 1.0 / sphere, side_of(direction)); }
    void add_known(double density, const V& direction) { test.add_known(density, 1.0 / sphere, side_of(direction)); }
    [[nodiscard]] double side_of(const V& direction) const {
      return std::clamp((1.0 + glm::dot(direction, axis)) / 2.0, 0.0, 1.0);
    }
    [[nodiscard]] bool passes() const { return test.passes(check.level_); }
    LightCheck& check;
    V axis{0.36, 0.48, 0.8};  // any
    detail::DensityTest test;
  };

  /// The densities of the point on the light, by next event and by emission, as densities of the direction at `from`.
  void distributions(const Point& from) {
    if (light_.is_infinite()) {
      DirectionSet next_event(*this), emission(*this);
      const auto next_event_at = [&](const V& to_light) {
        return number(light_.next_event_density(Point{}, Vec3<T>(-to_light), from));
      };
      const auto emission_at = [&](const V& to_light) {
        return number(light_.emitted(Point{}, Vec3<T>(-to_light)).density.origin);
      };
      for (std::size_t i = 0; i < samples_; ++i) {
        const auto sample = light_.sample_next_event(from, two());
        if (sample)
          next_event.add_sample(next_event_at(V(sample->to_light)), V(sample->to_light));
        else
          next_event.add_failure();
        const auto start = light_.sample_emission(two(), two());
        if (start)
          emission.add_sample(emission_at(-V(start->direction)), -V(start->direction));
        else
          emission.add_failure();
        const V any = next_event.draw();
        next_event.add_known(next_event_at(any), any);
        emission.add_known(emission_at(any), any);
      }
      findings_.judge(Convention::next_event_distribution, next_event.passes());
      findings_.judge(Convention::emission_origin_distribution, emission.passes());
      return;
    }

    // The directions of a cone around the light.
    V low(0), high(0);
    bool is_empty = true;
    for (std::size_t i = 0; i < 256; ++i) {
      const auto start = light_.sample_emission(two(), two());
      const auto sample = light_.sample_next_event(from, two());
      for (const Point* point : {start ? &start->origin : nullptr, sample ? &sample->origin : nullptr}) {
        if (point == nullptr) continue;
        const V position(point->position);
        low = is_empty ? position : glm::min(low, position);
        high = is_empty ? position : glm::max(high, position);
        is_empty = false;
      }
    }
    if (is_empty) return;
    const V center = (low + high) / 2.0, axis = center - V(from.position);
    const double radius = 0.55 * glm::length(high - low), away = glm::length(axis);
    if (!(away > 0.0)) return;
    const double cos_cone = away > radius ? std::sqrt(1.0 - (radius / away) * (radius / away)) : -1.0;
    const double known = 1.0 / (2.0 * pi<double> * (1.0 - cos_cone));
    const Frame<double> frame = Frame<double>::around(axis / away);

    // Every density is that of the first point of this light that the direction meets; 0 when it meets something else.
    const auto first_point = [&](const V& direction) {
      auto hit = scene_.intersect(towards(from, Vec3<T>(direction)));
      if (hit && hit->light != &light_) hit.reset();
      return hit;
    };
    const auto to_solid_angle = [&](const Point& point, const V& direction) {
      const V offset = V(point.position) - V(from.position);
      return glm::dot(offset, offset) / std::max(1e-6, std::abs(glm::dot(V(point.geometric_normal), direction)));
    };
    const auto next_event_at = [&](const Point& point, const V& direction) {
      const Vec3<T> leaving(-direction);
      if (is_black(light_.emitted(point, leaving).radiance)) return 0.0;
      return number(light_.next_event_density(point, leaving, from)) * to_solid_angle(point, direction);
    };
    const auto emission_at = [&](const Point& point, const V& direction) {
      const auto emitted = light_.emitted(point, Vec3<T>(-direction));
      if (is_black(emitted.radiance)) return 0.0;
      return number(emitted.density.origin) * to_solid_angle(point, direction);
    };
    const double sin_cone = away > radius ? radius / away : 1.0;
    const auto side_of = [&](const V& direction) {
      return std::clamp((1.0 + glm::dot(direction, frame.tangent) / sin_cone) / 2.0, 0.0, 1.0);
    };
    detail::DensityTest next_event, emission;
    double side = 0.0;  // h of the latest sample
    for (std::size_t i = 0; i < samples_; ++i) {
      const auto density_of = [&](const Point& point, const auto& density_at) {
        const V offset = V(point.position) - V(from.position);
        const double distance = glm::length(offset);
        if (!(distance > 0.0)) return 0.0;
        const V direction = offset / distance;
        const auto hit = first_point(direction);
        side = side_of(direction);
        // Small beside the light, too: seen from far away, the back of a ball is near its front.
        const double tolerance = std::min(0.01 * distance, std::max(0.02 * radius, 1e-5 * distance));
        if (!hit || glm::length(V(hit->point.position) - V(point.position)) > tolerance) return 0.0;
        if (glm::dot(direction, axis / away) < cos_cone) return 0.0;
        return density_at(hit->point, direction);
      };
      const auto sample = light_.sample_next_event(from, two());
      const double next_event_density = sample ? density_of(sample->origin, next_event_at) : 0.0;
      next_event.add_sample(next_event_density, known, side);
      const auto start = light_.sample_emission(two(), two());
      const double emission_density = start ? density_of(start->origin, emission_at) : 0.0;
      emission.add_sample(emission_density, known, side);

      const double z = 1.0 - uniform<double>(source_) * (1.0 - cos_cone),
                   turn = 2.0 * pi<double> * uniform<double>(source_);
      const double r = sqrt_or_zero(1.0 - z * z);
      const V direction = frame.to_world(V(r * std::cos(turn), r * std::sin(turn), z));
      const auto hit = first_point(direction);
      next_event.add_known(hit ? next_event_at(hit->point, direction) : 0.0, known, side_of(direction));
      emission.add_known(hit ? emission_at(hit->point, direction) : 0.0, known, side_of(direction));
    }
    findings_.judge(Convention::next_event_distribution, next_event.passes(level_));
    findings_.judge(Convention::emission_origin_distribution, emission.passes(level_));
  }

  /// `first` of an area light: the density of directions at a point that emission has drawn.
  void emission_directions() {
    if (light_.is_infinite()) return;
    // A start that fails may be part of `first`, or not: both are sound.
    DirectionSet directions(*this), with_failures(*this);
    for (std::size_t i = 0; i < samples_; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (!start) {
        with_failures.add_failure();
        continue;
      }
      const auto density = [&](const V& direction) {
        const auto emitted = light_.emitted(start->origin, Vec3<T>(direction));
        return number(emitted.density.first);
      };
      const V any = directions.draw();
      const double drawn = density(V(start->direction)), known = density(any);
      directions.axis = with_failures.axis = V(start->origin.geometric_normal);
      for (DirectionSet* set : {&directions, &with_failures}) {
        set->add_sample(drawn, V(start->direction));
        set->add_known(known, any);
      }
    }
    findings_.judge(Convention::emission_direction_distribution, directions.passes() || with_failures.passes());
  }

  /// The disk of an infinite light: its area against `first`, from the spread of the starts around the line that the
  /// disk is centred on. With a uniform density on a disk of radius R, the mean squared distance is R²/2.
  void emission_disk() {
    struct Start {
      V position, direction;
      double area;
    };
    std::vector<Start> starts;
    glm::dmat3 sum(0.0);
    V moment(0.0);
    for (std::size_t i = 0; i < samples_; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (!start || !(start->density.first > T(0))) continue;
      starts.push_back(
          {V(start->origin.position), V(start->direction), 1.0 / static_cast<double>(start->density.first)});
      const V& d = starts.back().direction;
      const glm::dmat3 across = glm::dmat3(1.0) - glm::outerProduct(d, d);
      sum += across;
      moment += across * starts.back().position;
    }
    if (starts.size() < 100) return;
    const auto [least, most] = std::minmax_element(starts.begin(), starts.end(),
                                                   [](const Start& a, const Start& b) { return a.area < b.area; });
    if (least->area < 0.99 * most->area) return;  // not uniform: this test does not apply
    const double count = static_cast<double>(starts.size());
    const V center = glm::inverse(sum + 1e-6 * count * glm::dmat3(1.0)) * moment;
    double squares = 0.0;
    for (const Start& start : starts) {
      const V offset = start.position - center;
      const V across = offset - glm::dot(offset, start.direction) * start.direction;
      squares += glm::dot(across, across);
    }
    // r² is uniform on [0, R²]: its standard deviation is R²/√12, so that of 2π mean(r²) / area is 0.58/√n; below 7
    // standard deviations chance alone exceeds 1e-11 only.
    const double ratio = 2.0 * pi<double> * squares / count / least->area;
    findings_.judge(Convention::emission_disk, std::abs(ratio - 1.0) < 0.02 + 7.0 * 0.58 / std::sqrt(count));
    std::size_t covered = 0;
    for (const Point& point : receivers_)
      for (std::size_t i = 0; i < 8; ++i) {
        const V& d = starts[uniform_index(source_, static_cast<std::uint32_t>(starts.size()))].direction;
        const V offset = V(point.position) - center;
        const V across = offset - glm::dot(offset, d) * d;
        covered += glm::dot(across, across) <= 1.05 * least->area / pi<double> ? 1U : 0U;
      }
    findings_.judge(Convention::emission_disk,
                    static_cast<double>(covered) > 0.9 * 8.0 * static_cast<double>(receivers_.size()));
  }

  const Sc& scene_;
  const Light& light_;
  std::span<const Point> receivers_;
  Source& source_;
  double level_;
  std::size_t samples_;
  Findings findings_;
};

/// Checks one light of a scene. `receivers`: points that the light may reach. All statistical tests together raise a
/// false alarm with a probability of at most `level`.
template <Scene Sc, UniformSource Source>
[[nodiscard]] Findings check_light(const Sc& scene, const typename Sc::Light& light,
                                   std::span<const SurfacePoint<ScalarOf<typename Sc::Spectrum>>> receivers,
                                   Source& source, double level = 1e-6, std::size_t samples = 8192) {
  // At most 7 tests.
  return LightCheck<Sc, Source>(scene, light, receivers, source, level / 7.0, samples).run();
}

}  // namespace gmis
