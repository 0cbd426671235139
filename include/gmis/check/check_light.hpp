#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "gmis/check/compare.hpp"
#include "gmis/check/light_directions.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

/// Checks one light of a scene: next events, emission and what rays that hit the light find,
/// against each other.
template <Scene Sc, UniformSource Source>
class LightCheck {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;

  /// `receivers`: points that the light may reach, on surfaces or between them. `level`: chance of
  /// a false alarm of each statistical test. `group`: of the findings.
  LightCheck(const Sc& scene, const Light& light, std::span<const Point> receivers, Source& source, double level,
             std::size_t samples, std::size_t ray_samples, std::size_t group)
      : scene_(scene),
        light_(light),
        receivers_(receivers),
        source_(source),
        level_(level),
        samples_(samples),
        ray_samples_(ray_samples),
        group_(group) {}

  /// Runs all checks of the light.
  [[nodiscard]] Findings run() {
    if (receivers_.empty()) return findings_;
    constexpr int cases = 512;
    for (int i = 0; i < cases; ++i) check_next_event();
    for (int i = 0; i < cases; ++i) check_emission();
    judge_guided_numbers();
    const double reach = glm::length(V(receivers_.front().position)) + 1.0;
    if (light_.is_delta())
      for (int i = 0; i < cases / 2; ++i) check_delta_intensity(reach);
    findings_.look_at(group_, {});
    detail::LightDirections<Sc, Source> directions(scene_, light_, source_, findings_, level_, samples_, ray_samples_);
    if (light_.is_delta()) {
      if (!light_.is_infinite()) directions.of_point_light(reach);
    } else {
      const std::size_t tested = std::min<std::size_t>(3, receivers_.size());
      for (std::size_t i = 0; i < tested; ++i)
        check_directions_from(receivers_[i * receivers_.size() / tested], directions);
      findings_.look_at(group_, {});
      if (!light_.is_infinite()) directions.judge_receivers();
      if (!light_.is_infinite()) directions.at_points_of_emission();
    }
    if (light_.is_infinite()) check_disk();
    judge_radiance();
    return findings_;
  }

 private:
  using V = Vec3<double>;

  /// A start on the disk of an infinite light.
  struct Start {
    V position, direction;
    double area;
  };

  [[nodiscard]] Vec2<T> two() {
    const T u = uniform<T>(source_);
    return {u, uniform<T>(source_)};
  }
  [[nodiscard]] const Point& receiver() {
    return receivers_[uniform_index(source_, static_cast<std::uint32_t>(receivers_.size()))];
  }
  [[nodiscard]] static double number(T x) { return static_cast<double>(x); }
  [[nodiscard]] static double cosine(const Vec3<T>& a, const Vec3<T>& b) { return std::abs(glm::dot(V(a), V(b))); }
  void compare(Convention convention, double found, double wanted, double tolerance = 0.01) {
    detail::compare(findings_, convention, found, wanted, tolerance);
  }
  void compare(Convention convention, const EmissionDensity<T>& found, const EmissionDensity<T>& wanted) {
    const bool is_origin = !detail::nearly(number(found.origin), number(wanted.origin));
    findings_.count(convention, !is_origin && detail::nearly(number(found.first), number(wanted.first)),
                    number(is_origin ? found.origin : found.first), number(is_origin ? wanted.origin : wanted.first));
  }
  void compare_channels(Convention convention, const S& found, const S& wanted, double factor) {
    detail::compare_channels(findings_, convention, found, wanted, factor, 0.02);
  }

  [[nodiscard]] static bool is_sound(const S& s) { return is_finite(s) && min_channel(s) >= T(0); }
  [[nodiscard]] static bool is_density(T x) { return x >= T(0) && std::isfinite(x); }
  [[nodiscard]] static bool is_density(const EmissionDensity<T>& x) {
    return is_density(x.origin) && is_density(x.first);
  }
  /// Counts whether values are sound; the result.
  bool check_values(bool are_sound) {
    findings_.count(Convention::light_value, are_sound);
    return are_sound;
  }

  /// A sample of a next event against `next_event_density`, `emitted` and what a ray finds.
  void check_next_event() {
    const Point& from = receiver();
    const auto sample = light_.sample_next_event(from, two());
    if (!sample || is_black(sample->weight)) return;
    findings_.look_at(group_, {V(from.position), V(0), V(sample->to_light)});
    if (!check_values(is_sound(sample->weight) && is_density(sample->next_event_density) &&
                      is_density(sample->density)))
      return;
    const V offset = V(sample->origin.position) - V(from.position);
    const double distance = glm::length(offset);
    const bool is_toward = light_.is_infinite() || glm::length(offset / distance - V(sample->to_light)) < 0.01;
    findings_.count(Convention::next_event_direction,
                    is_toward && detail::nearly(glm::length(V(sample->to_light)), 1.0, 1e-3));
    if (!is_toward) return;
    const double density = number(sample->next_event_density);
    if (light_.is_delta()) {
      compare(Convention::light_delta_densities, density, 1.0, 1e-3);
      compare(Convention::light_delta_densities, number(sample->density.origin), 1.0, 1e-3);
      return;
    }
    compare(Convention::next_event_two_densities, density,
            number(light_.next_event_density(sample->origin, -sample->to_light, from)));
    const auto emitted = light_.emitted(sample->origin, -sample->to_light);
    if (!check_values(is_sound(emitted.radiance) && is_density(emitted.density))) return;
    const double cos_light = light_.is_infinite() ? 1.0 : cosine(sample->origin.geometric_normal, sample->to_light);
    if (cos_light < 0.05) return;  // ruled by the rounding of the direction
    // A receiver behind the lamp, for example: the weight is wrong, whatever the density is.
    if (is_black(emitted.radiance))
      return findings_.count(Convention::next_event_weight, false, static_cast<double>(max_channel(sample->weight)),
                             0.0);
    compare(Convention::next_event_emission_density, sample->density, emitted.density);
    const double geometry = light_.is_infinite() ? 1.0 : cos_light / (distance * distance);
    if (density > 0.0)
      compare_channels(Convention::next_event_weight, sample->weight, emitted.radiance, geometry / density);
    if (light_.is_infinite() || !scene_.visible(segment(from, sample->origin, sample->to_light))) return;
    const auto hit = scene_.intersect(leave(from, sample->to_light));
    const bool is_hit = hit && hit->light == &light_ &&
                        glm::length(V(hit->point.position) - V(sample->origin.position)) < 0.01 * distance;
    findings_.count(Convention::light_not_hit, is_hit);
    if (is_hit)
      findings_.count(Convention::light_tag, sample->origin.tag == hit->point.tag,
                      static_cast<double>(sample->origin.tag), static_cast<double>(hit->point.tag));
  }

  /// A sample of emission against `emitted`.
  void check_emission() {
    const auto sample = light_.sample_emission(two(), two());
    if (!sample || is_black(sample->weight)) return;
    findings_.look_at(group_, {V(sample->origin.position), V(0), V(sample->direction)});
    if (!check_values(is_sound(sample->weight) && is_density(sample->density))) return;
    const bool is_surface = !light_.is_infinite() && !light_.is_delta();
    const double cos_light = is_surface ? glm::dot(V(sample->origin.geometric_normal), V(sample->direction)) : 1.0;
    compare(Convention::emission_unit, glm::length(V(sample->direction)), 1.0, 1e-3);
    if (std::abs(cos_light) < 0.05) return;  // ruled by the rounding of the direction
    check_guided(*sample);
    if (light_.is_delta()) {
      compare(Convention::light_delta_densities, number(sample->density.origin), 1.0, 1e-3);
      return;
    }
    const auto emitted = light_.emitted(sample->origin, sample->direction);
    if (!check_values(is_sound(emitted.radiance) && is_density(emitted.density))) return;
    compare(Convention::emission_two_densities, sample->density, emitted.density);
    const double densities = number(sample->density.origin) * number(sample->density.first);
    if (densities > 0.0)
      compare_channels(Convention::emission_weight, sample->weight, emitted.radiance, std::abs(cos_light) / densities);
  }

  /// The members of a guided light against the start that `sample_emission` made.
  void check_guided(const EmissionSample<S>& start) {
    if constexpr (GuidableLight<Light>) {
      const auto along = light_.emission_along(start.origin, start.direction);
      findings_.count(Convention::guided_start, along && glm::length(V(along->direction) - V(start.direction)) < 0.01);
      if (along) compare(Convention::guided_start, along->density, start.density);
      if (along) compare_channels(Convention::guided_start, along->weight, start.weight, 1.0);
      const auto numbers = light_.start_numbers(start.origin, start.direction);
      const auto other = light_.sample_emission(two(), two());
      if (!numbers || !other) return;
      const auto again =
          light_.is_infinite() ? light_.sample_emission(two(), *numbers) : light_.sample_emission(*numbers, two());
      if (!again) return;
      guided_.error += glm::length(drawn_first(*again) - drawn_first(start));
      guided_.spread += glm::length(drawn_first(*other) - drawn_first(start));
      guided_.size += glm::length(drawn_first(start));
    }
  }
  /// The part of a start that a guide draws first.
  [[nodiscard]] V drawn_first(const EmissionSample<S>& start) const {
    return light_.is_infinite() ? V(start.direction) : V(start.origin.position);
  }
  /// The numbers of `start_numbers` make nearly the same start again, beside the spread of all
  /// starts.
  void judge_guided_numbers() {
    if (!(guided_.spread > 0.0)) return;
    const double rounding = 32.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * guided_.size;
    findings_.judge(Convention::guided_numbers, guided_.error <= 0.02 * guided_.spread + rounding);
  }

  /// Emission of a delta light against its next events, `reach` away.
  void check_delta_intensity(double reach) {
    const auto start = light_.sample_emission(two(), two());
    if (!start || is_black(start->weight)) return;
    // A point that the light reaches along this direction.
    const double distance = reach * (0.5 + uniform<double>(source_));
    Point from{};
    from.position = Vec3<T>(V(start->origin.position) + distance * V(start->direction));
    findings_.look_at(group_, {V(from.position), V(0), -V(start->direction)});
    const auto sample = light_.sample_next_event(from, two());
    findings_.count(Convention::emission_intensity,
                    sample && glm::dot(V(sample->to_light), V(start->direction)) < -0.99);
    if (!sample) return;
    const double spread = light_.is_infinite() ? 1.0 : distance * distance;
    compare_channels(Convention::emission_intensity, sample->weight, start->weight,
                     number(start->density.first) / spread);
    compare(Convention::next_event_emission_density, number(sample->density.first), number(start->density.first), 0.02);
  }

  void check_directions_from(const Point& from, detail::LightDirections<Sc, Source>& directions) {
    findings_.look_at(group_, {V(from.position)});
    if (light_.is_infinite())
      directions.of_infinite_light(from);
    else
      directions.from_receiver(from);
  }

  /// Where both weights disagree with `emitted` and no density is wrong, the radiance of `emitted`
  /// is.
  void judge_radiance() {
    for (const Convention density :
         {Convention::next_event_distribution, Convention::emission_origin_distribution,
          Convention::emission_direction_distribution, Convention::emission_disk, Convention::emission_two_densities})
      if (findings_.is_broken(density, group_)) return;
    findings_.judge(Convention::emitted_radiance, !findings_.is_broken(Convention::next_event_weight, group_) ||
                                                      !findings_.is_broken(Convention::emission_weight, group_));
  }

  /// The disk of an infinite light: its area against `first`, from the spread of the starts around
  /// the line that the disk is centred on. With a uniform density on a disk of radius R, the mean
  /// squared distance is R²/2.
  void check_disk() {
    std::vector<Start> starts;
    glm::dmat3 sum(0.0);
    V moment(0.0);
    const V near(receivers_.front().position);  // the place 0 here: a scene may lie far from the origin
    for (std::size_t i = 0; i < samples_; ++i) {
      const auto start = light_.sample_emission(two(), two());
      if (!start || !(start->density.first > T(0))) continue;
      starts.push_back(
          {V(start->origin.position), V(start->direction), 1.0 / static_cast<double>(start->density.first)});
      const V& d = starts.back().direction;
      const glm::dmat3 across = glm::dmat3(1.0) - glm::outerProduct(d, d);
      sum += across;
      moment += across * (starts.back().position - near);
    }
    if (starts.size() < 100) return;
    const double count = static_cast<double>(starts.size());
    judge_disk(starts, near + glm::inverse(sum + 1e-6 * count * glm::dmat3(1.0)) * moment);
  }
  void judge_disk(const std::vector<Start>& starts, const V& center) {
    const auto [least, most] = std::minmax_element(starts.begin(), starts.end(),
                                                   [](const Start& a, const Start& b) { return a.area < b.area; });
    if (least->area < 0.99 * most->area) return;  // not uniform: this test does not apply
    const double count = static_cast<double>(starts.size());
    double squares = 0.0;
    for (const Start& start : starts) {
      const V offset = start.position - center;
      const V across = offset - glm::dot(offset, start.direction) * start.direction;
      squares += glm::dot(across, across);
    }
    // r² is uniform on [0, R²]: its standard deviation is R²/√12, so that of 2π mean(r²) / area is
    // 0.58/√n; chance alone exceeds 7 standard deviations with a probability below 1e-11.
    const double ratio = 2.0 * pi<double> * squares / count / least->area;
    findings_.judge(Convention::emission_disk, std::abs(ratio - 1.0) < 0.02 + 7.0 * 0.58 / std::sqrt(count),
                    1.0 / least->area, 1.0 / (ratio * least->area));
    judge_cover(starts, center, 1.15 * least->area / pi<double>);
  }
  /// The disk against what rays from the receivers meet, which light must reach: across the
  /// direction within the disk, and along it behind the disk. `limit`: the squared radius, with
  /// some room for the error of `center`.
  void judge_cover(const std::vector<Start>& starts, const V& center, double limit) {
    std::size_t met = 0, covered = 0;
    for (const Point& point : receivers_)
      for (int i = 0; i < 32; ++i) {
        const auto hit = scene_.intersect(leave(point, square_to_sphere(two())));
        if (!hit) continue;
        const Start& start = starts[uniform_index(source_, static_cast<std::uint32_t>(starts.size()))];
        const V& d = start.direction;
        const V position(hit->point.position), offset = position - center;
        const V across = offset - glm::dot(offset, d) * d;
        const bool is_behind = glm::dot(position - start.position, d) >= -1e-3 * std::sqrt(limit);
        ++met;
        covered += is_behind && glm::dot(across, across) <= limit ? 1U : 0U;
      }
    findings_.judge(Convention::emission_disk, static_cast<double>(covered) >= 0.999 * static_cast<double>(met));
  }

  const Sc& scene_;
  const Light& light_;
  std::span<const Point> receivers_;
  Source& source_;
  double level_;
  std::size_t samples_, ray_samples_, group_;
  Findings findings_;
  /// Sums of lengths over the starts of a guided light.
  struct Lengths {
    double error = 0.0, spread = 0.0, size = 0.0;
  } guided_;
};

/// Checks one light of a scene. `receivers`: points that the light may reach. All statistical tests
/// together raise a false alarm with a probability of at most `level`. `samples`: of each test;
/// `ray_samples`: of those that trace rays. `group`: of the findings.
template <Scene Sc, UniformSource Source>
[[nodiscard]] Findings check_light(const Sc& scene, const typename Sc::Light& light,
                                   std::span<const SurfacePoint<ScalarOf<typename Sc::Spectrum>>> receivers,
                                   Source& source, double level = 1e-6, std::size_t samples = 8192,
                                   std::size_t ray_samples = 8192, std::size_t group = 0) {
  // At most 10 tests.
  return LightCheck<Sc, Source>(scene, light, receivers, source, level / 10.0, samples, ray_samples, group).run();
}

}  // namespace gmis
