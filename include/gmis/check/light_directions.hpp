#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "gmis/check/density_test.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis::detail {

/// Do the samples of one light follow the densities that it states? All as densities of directions.
template <Scene Sc, UniformSource Source>
class LightDirections {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;
  using V = Vec3<double>;

  /// `level`: chance of a false alarm of each test.
  LightDirections(const Sc& scene, const Light& light, Source& source, Findings& findings, double level,
                  std::size_t samples)
      : scene_(scene), light_(light), source_(source), findings_(findings), level_(level), samples_(samples) {}

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

  /// `first` of an area light: the density of directions at a point that emission has drawn, in the frame of its normal.
  void at_points_of_emission() {
    std::vector<V> pilot;
    for (int i = 0; i < 400; ++i)
      if (const auto start = light_.sample_emission(two(), two()); start && !is_black(start->weight))
        pilot.push_back(frame_of(start->origin).to_local(V(start->direction)));
    const CapMixture known(pilot, rounding_of_directions, source_);
    // A start that fails may be part of `first`, or not: both are sound.
    DensityTest directions, with_failures;
    for (std::size_t i = 0; i < samples_; ++i) {
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
        test->add_sample(!is_black(start->weight), density(drawn), known.density(drawn), known.factors(drawn, axis));
        test->add_known(density(any), known.density(any), known.factors(any, axis));
      }
    }
    findings_.judge(Convention::emission_direction_distribution,
                    directions.passes(level_) || with_failures.passes(level_), directions.integral(),
                    directions.share());
  }

  /// The points of an area light, by next event and by emission, as directions from `from` in a cone around the light.
  void from_receiver(const Point& from) {
    const std::optional<Cone> cone = cone_around(from);
    if (!cone) return;
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
    test_points(Convention::next_event_distribution, from, *cone, next_event, [&](const Point& point, const V& to) {
      return number(light_.next_event_density(point, Vec3<T>(-to), from));
    });
    test_points(Convention::emission_origin_distribution, from, *cone, emission, [&](const Point& point, const V& to) {
      return number(light_.emitted(point, Vec3<T>(-to)).density.origin);
    });
  }

 private:
  static constexpr double rounding_of_directions = 200.0 * static_cast<double>(std::numeric_limits<T>::epsilon());
  static constexpr V axis{0.36, 0.48, 0.8};  // any

  /// All directions from a receiver in which the light may be.
  struct Cone {
    Frame<double> frame;  ///< around its axis
    double cosine;        ///< of half its angle; −1 for all directions
    double radius;        ///< of a ball around the light
    [[nodiscard]] double density() const { return 1.0 / (2.0 * pi<double> * (1.0 - cosine)); }
    /// Functions of a direction for `DensityTest`: all, and three slopes across the cone.
    [[nodiscard]] DensityTest::Factors factors(const V& direction) const {
      const double sine = cosine > -1.0 ? std::sqrt(1.0 - cosine * cosine) : 1.0;
      const double x = glm::dot(direction, frame.tangent) / sine, y = glm::dot(direction, frame.bitangent) / sine;
      return {1.0, std::clamp((1.0 + x) / 2.0, 0.0, 1.0), std::clamp((1.0 + y) / 2.0, 0.0, 1.0),
              std::clamp(1.0 - x * x - y * y, 0.0, 1.0)};
    }
  };

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
    findings_.judge(convention, result.passes(level_), result.integral(), result.share());
  }

  [[nodiscard]] std::optional<Cone> cone_around(const Point& from) {
    V low(0), high(0);
    bool is_empty = true;
    for (int i = 0; i < 256; ++i) {
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
    const V towards = (low + high) / 2.0 - V(from.position);
    const double radius = 0.55 * glm::length(high - low), away = glm::length(towards);
    if (is_empty || !(away > 0.0)) return std::nullopt;
    const double cosine = away > radius ? std::sqrt(1.0 - (radius / away) * (radius / away)) : -1.0;
    return Cone{Frame<double>::around(towards / away), cosine, radius};
  }
  /// Every density is that of the first point of this light that the direction meets; nothing when it meets something else, or
  /// a point that does not shine this way.
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
  /// A sampler of points against its density per area.
  template <class Sample, class Density>
  void test_points(Convention convention, const Point& from, const Cone& cone, const Sample& sample,
                   const Density& density) {
    DensityTest result;
    const auto add_sample = [&](const Point& point) {
      const V offset = V(point.position) - V(from.position);
      const double distance = glm::length(offset);
      if (!(distance > 0.0)) return result.add_failure();
      const V direction = offset / distance;
      const auto seen = first_point(from, direction);
      // Small beside the light, too: seen from far away, the back of a ball is near its front.
      const double tolerance = std::min(0.01 * distance, std::max(0.02 * cone.radius, 1e-5 * distance));
      if (!seen || glm::length(V(seen->position) - V(point.position)) > tolerance ||
          glm::dot(direction, cone.frame.normal) < cone.cosine)
        return result.add_failure();
      result.add_sample(true, density(*seen, direction) * to_solid_angle(from, *seen, direction), cone.density(),
                        cone.factors(direction));
    };
    for (std::size_t i = 0; i < samples_; ++i) {
      if (const auto point = sample())
        add_sample(*point);
      else
        result.add_failure();
      const double u = uniform<double>(source_);
      const V local = square_to_cone(Vec2<double>(u, uniform<double>(source_)), 1.0 - cone.cosine);
      const V any = glm::normalize(cone.frame.to_world(local));
      const auto seen = first_point(from, any);
      result.add_known(seen ? density(*seen, any) * to_solid_angle(from, *seen, any) : 0.0, cone.density(),
                       cone.factors(any));
    }
    findings_.judge(convention, result.passes(level_), result.integral(), result.share());
  }

  const Sc& scene_;
  const Light& light_;
  Source& source_;
  Findings& findings_;
  double level_;
  std::size_t samples_;
};

}  // namespace gmis::detail
