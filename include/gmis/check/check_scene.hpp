#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/check/check_camera.hpp"
#include "gmis/check/check_effects.hpp"
#include "gmis/check/check_hits.hpp"
#include "gmis/check/check_light.hpp"
#include "gmis/check/check_light_choice.hpp"
#include "gmis/check/check_surface.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/check/scatter_statistics.hpp"
#include "gmis/check/surface_points.hpp"
#include "gmis/core/argument_error.hpp"
#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/light_choice.hpp"

namespace gmis {

/// How much `check_scene` tries.
struct SceneCheckSettings {
  std::uint64_t seed = 0;         ///< of the random numbers
  std::size_t walks = 512;        ///< subpaths from the camera, and as many from the lights
  int depth = 4;                  ///< edges of a subpath
  std::size_t rays = 4096;        ///< from surfaces in any direction, and as many to places with few hits
  std::size_t points = 64;        ///< of each group of surfaces, at which pairs of directions are tried
  std::size_t surfaces = 8;       ///< of each group, at which many directions are drawn
  std::size_t samples = 8192;     ///< of each statistical test, at least one
  std::size_t most_lights = 256;  ///< lights that are looked at, the most likely ones
  std::size_t receivers = 16;     ///< surface points, at least one, where a scene chooses lights for the receiver
  double level = 1e-6;            ///< chance in ]0, 1[ that a sound scene is called broken, of all tests together
};

/// Samples your own scene and names the conventions that it breaks. It finds mistakes that
/// compile, such as a density per area in place of one per steradian; most of them change the
/// picture only where techniques are combined.
///
/// Call it once, from a test or at the start of a program while the adapter is written; it takes a
/// fraction of a second. What it finds is certain but for rounding and `level`. What it does not
/// find may still be wrong: it sees only what subpaths from the camera and from the lights and rays
/// between surfaces meet, and nothing of the renderer's own picture.
template <Scene Sc>
class SceneChecker {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Bsdf = typename Sc::Bsdf;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;

  /// Prepares; nothing is sampled yet. Throws std::invalid_argument for settings without samples or
  /// receivers, and for a level outside ]0, 1[.
  SceneChecker(const Sc& scene, const SceneCheckSettings& settings)
      : scene_(scene),
        settings_(settings),
        source_(settings.seed, 0, 0, 7),
        points_(scene, settings.points, settings.depth, source_),
        choice_(scene, settings.level / 4.0, findings_) {
    require_argument(settings.samples > 0, "SceneCheckSettings::samples is 0: set it to 1 at least");
    require_argument(settings.receivers > 0, "SceneCheckSettings::receivers is 0: set it to 1 at least");
    require_argument(settings.level > 0.0 && settings.level < 1.0,
                     "SceneCheckSettings::level is a false-alarm rate: set it between 0 and 1");
  }

  /// Samples the scene; what it found.
  [[nodiscard]] Findings run() {
    find_points();
    check_choice();
    findings_.add(check_camera(scene_.camera(), source_, points_.distance()));
    check_hits();
    check_surfaces();
    check_lights();
    return findings_;
  }

 private:
  using V = Vec3<double>;
  using Choice = detail::LightChoiceCheck<Sc>;

  void find_points() {
    points_.walk_from_camera(settings_.walks);
    std::vector<const Light*> lights;
    for (std::size_t i = 0; i < settings_.walks; ++i)
      if (const auto choice = scene_.sample_light(uniform<T>(source_)); choice.light != nullptr) {
        points_.walk_from_light(*choice.light);
        if (std::find(lights.begin(), lights.end(), choice.light) == lights.end()) lights.push_back(choice.light);
      }
    lights.resize(std::min(lights.size(), settings_.most_lights));
    for (const Light* light : lights) points_.seek_light(*light);
    points_.seek_rare(settings_.rays);
  }

  void check_choice() {
    choice_.choose(4 * settings_.samples, points_.hits(), source_);
    if constexpr (chooses_for_receiver<Sc>()) {
      const auto hits = points_.hits();
      const std::size_t stride = std::max<std::size_t>(1, hits.size() / settings_.receivers);
      const double share = 1.0 / (2.0 * static_cast<double>(2 * settings_.receivers));
      for (std::size_t i = 0; i < hits.size(); i += stride)
        if (!hits[i].hit.bsdf.is_purely_delta()) choice_.choose_at(hits[i], settings_.samples, share, source_);
    }
  }

  void check_hits() {
    detail::HitCheck<Sc> check(scene_, points_.distance(), source_, findings_);
    detail::EffectsCheck<Sc> effects(scene_, source_, findings_);
    const auto hits = points_.hits();
    for (const auto& hit : hits) {
      check.check(hit);
      effects.check(hit);
    }
    const auto any = [&]() -> const auto& {
      return hits[uniform_index(source_, static_cast<std::uint32_t>(hits.size()))];
    };
    for (std::size_t i = 0; i < settings_.walks && hits.size() > 1; ++i) {
      const auto& first = any();
      check.check_pair(first, any());
    }
  }

  void check_surfaces() {
    constexpr int pairs = 16;
    std::size_t groups = 0;
    for (std::size_t group = 0; group < detail::SurfacePoints<Sc>::most_groups; ++group)
      groups += points_.of_group(group, 1).size();
    const double level =
        settings_.level / (4.0 * static_cast<double>(std::max<std::size_t>(1, groups) * (settings_.surfaces + 2)));
    // A few pairs everywhere, since a small object may look like a large one; more in each group.
    for (std::size_t i = 0; i < points_.hits().size(); ++i) check_surface(points_.hits()[i], 1);
    for (std::size_t group = 0; group < groups; ++group) {
      for (const std::size_t i : points_.of_group(group, settings_.points)) check_surface(points_.hits()[i], pairs);
      draw_directions(group, level);
    }
  }
  void check_surface(const detail::CheckedHit<Sc>& at, int pairs) {
    const Vec3<T> to_prev = -at.ray.direction;
    findings_.look_at(at.group, {V(at.hit.point.position), V(to_prev)});
    const auto bsdf_for = [&](const Vec3<T>& to) { return bsdf_at(at, to); };
    SurfaceCheck<decltype(bsdf_for), T, Philox>(bsdf_for, at.hit.point, to_prev, source_, findings_).run(pairs);
  }
  /// The BSDF that the engine would find: that of a ray that arrives from `to`. Nothing where no
  /// ray finds the same point.
  [[nodiscard]] std::optional<Bsdf> bsdf_at(const detail::CheckedHit<Sc>& at, const Vec3<T>& to) const {
    const Point& point = at.hit.point;
    const V position(point.position);
    if (glm::length(V(to) + V(at.ray.direction)) < 1e-9) return at.hit.bsdf;
    if (std::abs(glm::dot(V(to), V(point.geometric_normal))) < 0.05) return std::nullopt;
    const auto obstacle = scene_.intersect(leave(point, to));
    double beyond = 0.01 * points_.distance();
    if (obstacle) beyond = std::min(beyond, 0.5 * glm::length(V(obstacle->point.position) - position));
    if (beyond < 1e-4 * points_.distance()) return std::nullopt;
    const auto hit = scene_.intersect({Vec3<T>(position + beyond * V(to)), -to});
    if (!hit || glm::length(V(hit->point.position) - position) > 0.02 * beyond) return std::nullopt;
    // In foliage and at edges another surface may lie as near, whose BSDF is another one.
    if (glm::dot(V(hit->point.shading_normal), V(point.shading_normal)) < 1.0 - 1e-4) return std::nullopt;
    return hit->bsdf;
  }
  /// The distribution of `sample` at some points of a group, each by itself and all together.
  void draw_directions(std::size_t group, double level) {
    detail::ScatterStatistics<S> importance, radiance, steep;
    std::size_t drawn = 0;
    for (const std::size_t i : points_.of_group(group, settings_.surfaces)) {
      const auto& at = points_.hits()[i];
      const V to_prev = -V(at.ray.direction), normal(at.hit.point.shading_normal);
      if (std::abs(glm::dot(to_prev, normal)) < 0.02) continue;
      const bool is_radiance = ++drawn % 4 == 0;
      findings_.look_at(group, {V(at.hit.point.position), to_prev});
      detail::ScatterStatistics<S> here;
      here.draw(at.hit.bsdf, normal, -at.ray.direction,
                is_radiance ? TransportMode::radiance : TransportMode::importance, settings_.samples, source_);
      here.judge(findings_, level);
      (is_radiance ? radiance : importance).add(here);
      // Near grazing angles a dark, smooth coat scatters many times its albedo.
      if (!is_radiance && std::abs(glm::dot(to_prev, normal)) > 0.4 &&
          detail::has_mirrored_side(normal, V(at.hit.point.geometric_normal), to_prev))
        steep.add(here);
    }
    importance.judge(findings_, level);
    steep.judge_albedo(findings_);
    radiance.judge(findings_, level);
  }

  void check_lights() {
    const std::vector<Point> between = points_between();
    const std::size_t count = std::min(choice_.lights().size(), settings_.most_lights);
    if (count == 0 || between.empty()) return;
    // Eight lights get all samples that trace rays; more of them share these.
    const std::size_t ray_samples =
        std::min(settings_.samples, std::max<std::size_t>(1024, 8 * settings_.samples / count));
    detail::EffectsCheck<Sc> effects(scene_, source_, findings_);
    for (std::size_t i = 0; i < count; ++i) {
      const Light& light = *choice_.lights()[i];
      effects.check(light, between.front(), Choice::first_group + i);
      const std::vector<Point> receivers = with_points_behind(light, between);
      findings_.add(check_light(scene_, light, std::span<const Point>(receivers), source_,
                                settings_.level / (4.0 * static_cast<double>(count)), settings_.samples, ray_samples,
                                Choice::first_group + i));
    }
  }
  /// Points halfway along rays, which are not on a light.
  [[nodiscard]] std::vector<Point> points_between() const {
    std::vector<Point> result;
    const auto hits = points_.hits();
    for (std::size_t i = 0; i < hits.size() && result.size() < 64; i += 1 + hits.size() / 64) {
      result.emplace_back();
      result.back().position = Vec3<T>((V(hits[i].ray.origin) + V(hits[i].hit.point.position)) / 2.0);
    }
    return result;
  }
  /// `points`, every third of them replaced by one behind the light where it has a back: a lamp
  /// under a ceiling has few receivers there.
  [[nodiscard]] std::vector<Point> with_points_behind(const Light& light, std::vector<Point> points) {
    for (std::size_t i = 2; i < points.size(); i += 3)
      if (const auto behind = point_behind(light)) points[i].position = *behind;
    return points;
  }
  /// A point that a ray passes which leaves the back of the light; nothing where there is no room,
  /// or where the light is closed.
  [[nodiscard]] std::optional<Vec3<T>> point_behind(const Light& light) {
    if (light.is_delta() || light.is_infinite()) return std::nullopt;
    const auto two = [&] {
      const T u = uniform<T>(source_);
      return Vec2<T>(u, uniform<T>(source_));
    };
    const Vec2<T> uv_origin = two();
    const auto start = light.sample_emission(uv_origin, two());
    if (!start) return std::nullopt;
    const V normal(start->origin.geometric_normal), front(start->direction);
    const V back = front - 2.0 * glm::dot(front, normal) * normal;
    const auto hit = scene_.intersect(leave(start->origin, Vec3<T>(back)));
    const V position(start->origin.position);
    const double room = hit ? glm::length(V(hit->point.position) - position) : 2.0 * points_.distance();
    if ((hit && hit->light == &light) || room < 0.01 * points_.distance()) return std::nullopt;
    return Vec3<T>(position + 0.5 * room * back);
  }

  const Sc& scene_;
  SceneCheckSettings settings_;
  Philox source_;
  Findings findings_;
  detail::SurfacePoints<Sc> points_;
  Choice choice_;
};

/// Samples the scene and names the conventions that it breaks (`SceneChecker`). Throws as the
/// constructor of `SceneChecker` does.
///
///     const gmis::Findings findings = gmis::check_scene(scene);
///     std::fputs(findings.text().c_str(), stderr);
template <Scene Sc>
[[nodiscard]] Findings check_scene(const Sc& scene, const SceneCheckSettings& settings = {}) {
  return SceneChecker<Sc>(scene, settings).run();
}

/// \cond
// For a type that is no scene: the compiler names what it lacks.
template <class Sc>
requires(!Scene<Sc>) IsScene<Sc> check_scene(const Sc&, const SceneCheckSettings& = {});
/// \endcond

}  // namespace gmis
