#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/check/density_test.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis::detail {

/// Tests whether the samples of one light follow the densities that it states, each converted to a
/// density of directions.
template <Scene Sc, UniformSource Source>
class LightDirections {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;
  using V = Vec3<double>;

  /// `level`: chance of a false alarm of each test. `samples`: of each test; `ray_samples`: of
  /// those that trace rays.
  LightDirections(const Sc& scene, const Light& light, Source& source, Findings& findings, double level,
                  std::size_t samples, std::size_t ray_samples)
      : scene_(scene),
        light_(light),
        source_(source),
        findings_(findings),
        level_(level),
        samples_(samples),
        ray_samples_(ray_samples) {}

  /// The directions of an infinite light, by next event from `from` and by emission.
  void of_infinite_light(const Point& from) {
    const auto next_event = [&]() -> std::optional<V> {
      const auto sample = light_.sample_next_event(from, two());
      if (!sample || is_black(sample->weight)) return std::nullopt;
      return V(sample->to_light);
    };
    const auto emission = [&]() -> std::optional<V> {
      const auto start = light_.sample_emission(two(), two());
      if (!start || is_black(start->weight)) return std::nullopt;
      return -V(start->direction);
    };
    const auto emits = [&](const V& to_light) {
      return !is_black(light_.emitted(Point{}, Vec3<T>(-to_light)).radiance);
    };
    test(Convention::next_event_distribution, next_event, [&](const V& to_light) {
      return emits(to_light) ? number(light_.next_event_density(Point{}, Vec3<T>(-to_light), from)) : 0.0;
    });
    test(Convention::emission_origin_distribution, emission, [&](const V& to_light) {
      return emits(to_light) ? number(light_.emitted(Point{}, Vec3<T>(-to_light)).density.origin) : 0.0;
    });
  }

  /// `first` of a point light, as its next events state it. `reach`: a distance in scene units.
  void of_point_light(double reach) {
    const auto center = light_.sample_emission(two(), two());
    if (!center) return;
    const V position(center->origin.position);
    const auto sample = [&]() -> std::optional<V> {
      const auto start = light_.sample_emission(two(), two());
      if (!start || is_black(start->weight)) return std::nullopt;
      return V(start->direction);
    };
    test(Convention::emission_direction_distribution, sample, [&](const V& direction) {
      Point from{};
      from.position = Vec3<T>(position + reach * direction);
      const auto seen = light_.sample_next_event(from, {T(0.5), T(0.5)});
      return seen && !is_black(seen->weight) ? number(seen->density.first) : 0.0;
    });
  }

  /// `first` of an area light: the density of directions at a point that emission has drawn, in the
  /// frame of its normal.
  void at_points_of_emission() {
    // Mistakes in the law of the angle with the normal show most along it and near the horizon. No
    // ray is traced, so there can be more samples.
    constexpr V normal{0, 0, 1};
    const std::size_t samples = 2 * samples_;
    std::vector<V> pilot;
    for (int i = 0; i < 400; ++i)
      if (const auto start = light_.sample_emission(two(), two()); start && !is_black(start->weight))
        pilot.push_back(frame_of(start->origin).to_local(V(start->direction)));
    const CapMixture known(pilot, rounding_of_directions, source_);
    // A start that fails may be part of `first`, or not: both are sound.
    DensityTest directions, with_failures;
    for (std::size_t i = 0; i < samples; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (!start) {
        with_failures.add_failure();
        continue;
      }
      const Frame<double> frame = frame_of(start->origin);
      const auto density = [&](const V& local) {
        const auto emitted = light_.emitted(start->origin, Vec3<T>(frame.to_world(local)));
        return is_black(emitted.radiance) ? 0.0 : number(emitted.density.first);
      };
      const V drawn = frame.to_local(V(start->direction)), any = known.draw(source_);
      for (DensityTest* test : {&directions, &with_failures}) {
        test->add_sample(!is_black(start->weight), density(drawn), known.density(drawn), known.factors(drawn, normal));
        test->add_known(density(any), known.density(any), known.factors(any, normal));
      }
    }
    findings_.judge(Convention::emission_direction_distribution,
                    directions.passes(level_) || with_failures.passes(level_), directions.integral(),
                    directions.share());
  }

  /// The points of an area light, by next event and by emission, as directions from `from`.
  void from_receiver(const Point& from) {
    const double radius = radius_around();
    const auto next_event = [&]() -> std::optional<Point> {
      const auto sample = light_.sample_next_event(from, two());
      if (!sample) return std::nullopt;
      return sample->origin;
    };
    const auto emission = [&]() -> std::optional<Point> {
      const auto start = light_.sample_emission(two(), two());
      if (!start) return std::nullopt;
      return start->origin;
    };
    const auto next_event_density = [&](const Point& point, const V& to) {
      return number(light_.next_event_density(point, Vec3<T>(-to), from));
    };
    const auto emission_density = [&](const Point& point, const V& to) {
      return number(light_.emitted(point, Vec3<T>(-to)).density.origin);
    };
    // Where a sampler gives too few points, those of the other one say where the light is.
    std::vector<V> by_next_event = pilot_of(from, radius, next_event), by_emission = pilot_of(from, radius, emission);
    if (by_next_event.size() < CapMixture::least_draws) by_next_event = by_emission;
    if (by_emission.size() < CapMixture::least_draws) by_emission = by_next_event;
    test_points(Convention::next_event_distribution, from, radius, by_next_event, next_event, next_event_density,
                next_events_);
    test_points(Convention::emission_origin_distribution, from, radius, by_emission, emission, emission_density,
                emissions_);
  }
  /// Verdicts on all draws of `from_receiver` together.
  void judge_receivers() {
    judge(Convention::next_event_distribution, next_events_);
    judge(Convention::emission_origin_distribution, emissions_);
  }

 private:
  static constexpr double rounding_of_directions = 200.0 * static_cast<double>(std::numeric_limits<T>::epsilon());
  static constexpr V axis{0.36, 0.48, 0.8};  // any

  [[nodiscard]] Vec2<T> two() {
    const T u = uniform<T>(source_);
    return {u, uniform<T>(source_)};
  }
  [[nodiscard]] static double number(T x) {
    const double value = static_cast<double>(x);
    return std::isfinite(value) ? value : 0.0;
  }
  [[nodiscard]] static Frame<double> frame_of(const Point& point) {
    const V normal(point.geometric_normal);
    return Frame<double>::around(glm::length(normal) > 0.5 ? glm::normalize(normal) : V(0, 0, 1));
  }

  /// A sampler of directions against its density.
  template <class Sample, class Density>
  void test(Convention convention, const Sample& sample, const Density& density) {
    std::vector<V> pilot;
    for (int i = 0; i < 400; ++i)
      if (const auto direction = sample()) pilot.push_back(glm::normalize(*direction));
    const CapMixture known(pilot, rounding_of_directions, source_);
    DensityTest result;
    for (std::size_t i = 0; i < samples_; ++i) {
      if (const auto drawn = sample())
        result.add_sample(true, density(*drawn), known.density(*drawn), known.factors(*drawn, axis));
      else
        result.add_failure();
      const V any = known.draw(source_);
      result.add_known(density(any), known.density(any), known.factors(any, axis));
    }
    judge(convention, result);
  }

  /// Radius of a ball around the light.
  [[nodiscard]] double radius_around() {
    V low(0), high(0);
    bool is_empty = true;
    for (int i = 0; i < 256; ++i)
      if (const auto start = light_.sample_emission(two(), two())) {
        const V position(start->origin.position);
        low = is_empty ? position : glm::min(low, position);
        high = is_empty ? position : glm::max(high, position);
        is_empty = false;
      }
    return 0.55 * glm::length(high - low);
  }
  /// The first point that the direction meets, where densities are read; nothing when it is not on
  /// this light or emits nothing this way.
  [[nodiscard]] std::optional<Point> first_point(const Point& from, const V& direction) const {
    const auto hit = scene_.intersect(leave(from, Vec3<T>(direction)));
    if (!hit || hit->light != &light_) return std::nullopt;
    if (is_black(light_.emitted(hit->point, Vec3<T>(-direction)).radiance)) return std::nullopt;
    return hit->point;
  }
  [[nodiscard]] static double to_solid_angle(const Point& from, const Point& point, const V& direction) {
    const V offset = V(point.position) - V(from.position);
    return glm::dot(offset, offset) / std::max(1e-6, std::abs(glm::dot(V(point.geometric_normal), direction)));
  }
  /// The direction from `from` to a point that a sampler made, and what a ray finds there; nothing
  /// where the ray finds another point.
  [[nodiscard]] std::optional<std::pair<V, Point>> seen_from(const Point& from, const Point& point,
                                                             double radius) const {
    const V offset = V(point.position) - V(from.position);
    const double distance = glm::length(offset);
    if (!(distance > 0.0)) return std::nullopt;
    const V direction = offset / distance;
    const auto seen = first_point(from, direction);
    // Small beside the light, too: seen from far away, the back of a ball is near its front.
    const double tolerance = std::min(0.01 * distance, std::max(0.02 * radius, 1e-5 * distance));
    if (!seen || glm::length(V(seen->position) - V(point.position)) > tolerance) return std::nullopt;
    return std::pair{direction, *seen};
  }
  /// Directions from `from` to points that a sampler makes.
  template <class Sample>
  [[nodiscard]] std::vector<V> pilot_of(const Point& from, double radius, const Sample& sample) {
    std::vector<V> pilot;
    for (int i = 0; i < 400; ++i)
      if (const auto point = sample())
        if (const auto seen = seen_from(from, *point, radius)) pilot.push_back(seen->first);
    return pilot;
  }
  /// A sampler of points against its density per area; the draws are added to `all`. `pilot`:
  /// directions in which the light lies.
  template <class Sample, class Density>
  void test_points(Convention convention, const Point& from, double radius, const std::vector<V>& pilot,
                   const Sample& sample, const Density& density, DensityTest& all) {
    const CapMixture known(pilot, rounding_of_directions, source_);
    DensityTest result;
    for (std::size_t i = 0; i < ray_samples_; ++i) {
      const auto point = sample();
      const auto seen = point ? seen_from(from, *point, radius) : std::nullopt;
      if (seen)
        result.add_sample(true, density(seen->second, seen->first) * to_solid_angle(from, seen->second, seen->first),
                          known.density(seen->first), known.factors(seen->first, axis));
      else
        result.add_failure();
      const V any = known.draw(source_);
      const auto met = first_point(from, any);
      result.add_known(met ? density(*met, any) * to_solid_angle(from, *met, any) : 0.0, known.density(any),
                       known.factors(any, axis));
    }
    judge(convention, result);
    all.add(result);
  }
  void judge(Convention convention, const DensityTest& test) {
    findings_.judge(convention, test.passes(level_), test.integral(), test.share());
  }

  const Sc& scene_;
  const Light& light_;
  Source& source_;
  Findings& findings_;
  double level_;
  std::size_t samples_, ray_samples_;
  DensityTest next_events_, emissions_;
};

}  // namespace gmis::detail
