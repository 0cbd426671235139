#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/check/check_camera.hpp"
#include "gmis/check/check_light.hpp"
#include "gmis/check/check_surface.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/core/light_choice.hpp"
#include "gmis/core/concept_diagnostics.hpp"

namespace gmis {

/// How much `check_scene` tries.
struct SceneCheckSettings {
  /// Of the random numbers.
  std::uint64_t seed = 0;
  std::size_t walks = 512;      ///< subpaths from the camera, and as many from the lights
  int depth = 4;                ///< edges of a subpath
  std::size_t surfaces = 24;    ///< points at which many directions are drawn
  std::size_t samples = 8192;   ///< of each statistical test
  std::size_t most_lights = 8;  ///< lights that are looked at, the most likely ones
  std::size_t receivers = 16;   ///< surface points at which lights are chosen, by a scene that chooses for the receiver
  double level = 1e-6;          ///< chance that a sound scene is called broken, of all statistical tests together
};

/// Samples a scene of one's own and names the conventions that it breaks. It finds mistakes that compile, such as a
/// density per area in place of one per steradian; most of them change the picture only where techniques are combined.
///
/// Call it once, from a test or at the start of a program while the adapter is written; it takes a fraction of a second. What it
/// finds is certain but for rounding and `level`. What it does not find may still be wrong: it sees only what subpaths
/// from the camera and from the lights meet, and nothing of the renderer's own picture.
template <Scene Sc>
class SceneChecker {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Bsdf = typename Sc::Bsdf;
  using Light = typename Sc::Light;
  using HitType = Hit<T, Bsdf, Light>;
  using Point = SurfacePoint<T>;

  /// Prepares; nothing is sampled yet.
  SceneChecker(const Sc& scene, const SceneCheckSettings& settings)
      : scene_(scene), settings_(settings), source_(settings.seed, 0, 0, 7) {}

  /// Samples the scene; what it found.
  [[nodiscard]] Findings run() {
    walk_from_camera();
    choose_lights();
    walk_from_lights();
    choose_lights_for_receivers();
    measure();
    Findings camera = check_camera(scene_.camera(), source_, distance_);
    findings_.add(camera);
    for (const Vertex& vertex : vertices_) check_hit(vertex);
    check_visibility();
    check_surfaces();
    check_lights();
    return findings_;
  }

 private:
  using V = Vec3<double>;

  struct Vertex {
    Ray<T> ray;  ///< that found the hit
    Point from;
    HitType hit;
    double distance;
    bool is_from_camera;
  };

  [[nodiscard]] T random_number() { return uniform<T>(source_); }
  [[nodiscard]] Vec2<T> two() {
    const T u = random_number();
    return {u, random_number()};
  }

  /// Follows a subpath and keeps its vertices.
  void follow(Point from, Vec3<T> direction, TransportMode mode) {
    for (int depth = 0; depth < settings_.depth; ++depth) {
      const Ray<T> ray = leave(from, direction);
      const auto hit = scene_.intersect(ray);
      if (!hit) {
        return;
      }
      const double distance = glm::length(V(hit->point.position) - V(ray.origin));
      vertices_.push_back({ray, from, *hit, distance, mode == TransportMode::radiance});
      const T u = random_number();
      const auto sample = hit->bsdf.sample(-direction, u, two(), mode);
      if (!sample || !(glm::length(sample->to_next) > T(0.9) && glm::length(sample->to_next) < T(1.1))) return;
      from = hit->point;
      direction = sample->to_next;
    }
  }

  void walk_from_camera() {
    const glm::ivec2 size = scene_.camera().resolution();
    for (std::size_t i = 0; i < settings_.walks; ++i) {
      const Vec2<T> place = two();
      const glm::ivec2 pixel = glm::min(glm::ivec2(Vec2<double>(place) * Vec2<double>(size)), size - 1);
      const Vec2<T> uv = two();
      if (const auto ray = scene_.camera().sample_ray(pixel, uv, two()))
        follow(ray->origin, ray->direction, TransportMode::radiance);
    }
  }

  /// Chooses lights as the engine does, and counts how often each is chosen.
  void choose_lights() {
    const std::size_t count = 4 * settings_.samples;
    std::map<const Light*, std::size_t> chosen, first_draw;
    for (std::size_t i = 0; i < count; ++i) {
      const auto choice = scene_.sample_light(random_number());
      if (choice.light == nullptr) continue;
      first_draw.emplace(choice.light, i);
      if (++chosen[choice.light] > 16) continue;
      const double stated = static_cast<double>(choice.selection_probability);
      findings_.count(Convention::light_choice,
                      detail::nearly(stated, static_cast<double>(scene_.selection_probability(*choice.light)), 1e-3));
    }
    for (const auto& [light, times] : chosen) {
      lights_.push_back({times, light});
      const double p = static_cast<double>(scene_.selection_probability(*light));
      const double alarm = settings_.level / (6.0 * static_cast<double>(chosen.size()));
      findings_.judge(Convention::light_frequency, is_plausible(times, count, p, alarm));
      if (light->is_infinite() && !light->is_delta()) {
        bool is_listed = false;
        for (const Light* listed : scene_.infinite_lights()) is_listed = is_listed || listed == light;
        findings_.judge(Convention::light_infinite_list, is_listed);
      }
    }
    // Pointers differ from run to run: an order of their own would make the checks differ, too. Lights of one count come in
    // the order in which they were drawn.
    std::sort(lights_.begin(), lights_.end(), [&](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first : first_draw[a.second] < first_draw[b.second];
    });
  }

  /// True when an event of probability `p` may have come `times` times in `count` draws: Bernstein's bound for a false
  /// alarm with a probability of at most `alarm`.
  [[nodiscard]] static bool is_plausible(std::size_t times, std::size_t count, double p, double alarm) {
    const double n = static_cast<double>(count), share = static_cast<double>(times) / n;
    const double logarithm = std::log(2.0 / alarm);
    const double reach = std::sqrt(2.0 * std::max(p * (1.0 - p), 0.0) * logarithm / n) + logarithm / n;
    return std::abs(share - p) <= reach + 1e-4;
  }

  /// The light choice of a scene that chooses for the receiver, at hits of subpaths.
  void choose_lights_for_receivers() {
    if constexpr (chooses_for_receiver<Sc>()) {
      // Numbers of its own, so that the other checks do not depend on this one.
      const Philox others = std::exchange(source_, Philox(settings_.seed, 0, 0, 8));
      const std::size_t stride = std::max<std::size_t>(1, vertices_.size() / settings_.receivers);
      for (std::size_t i = 0; i < vertices_.size(); i += stride)
        if (!vertices_[i].hit.bsdf.is_purely_delta()) choose_lights_for(vertices_[i]);
      source_ = others;
    }
  }
  void choose_lights_for(const Vertex& receiver) requires SceneWithReceiverChoice<Sc> {
    const Point& from = receiver.hit.point;
    const std::size_t looked_at = std::min(lights_.size(), settings_.most_lights);
    std::map<const Light*, std::size_t> chosen;
    for (std::size_t i = 0; i < looked_at; ++i) chosen[lights_[i].second] = 0;
    for (std::size_t i = 0; i < settings_.samples; ++i) {
      const auto choice = scene_.sample_light(from, random_number());
      if (choice.light == nullptr) continue;
      if (++chosen[choice.light] > 16) continue;
      findings_.count(Convention::receiver_choice,
                      detail::nearly(static_cast<double>(choice.selection_probability),
                                     static_cast<double>(scene_.selection_probability(*choice.light, from)), 1e-3));
    }
    const double alarm =
        settings_.level / (12.0 * static_cast<double>(2 * settings_.receivers) * static_cast<double>(chosen.size()));
    for (const auto& [light, times] : chosen)
      findings_.judge(Convention::receiver_frequency,
                      is_plausible(times, settings_.samples,
                                   static_cast<double>(scene_.selection_probability(*light, from)), alarm));
    for (std::size_t i = 0; i < looked_at; ++i) {
      const Light& light = *lights_[i].second;
      if (reaches(light, receiver))
        findings_.count(Convention::receiver_reach, scene_.selection_probability(light, from) > T(0));
    }
  }
  /// True when one sample of the light is seen from the receiver and scattered there.
  [[nodiscard]] bool reaches(const Light& light, const Vertex& receiver) {
    const Point& from = receiver.hit.point;
    const auto sample = light.sample_next_event(from, two());
    if (!sample || is_black(sample->weight)) return false;
    if (is_black(receiver.hit.bsdf.evaluate(-receiver.ray.direction, sample->to_light, TransportMode::radiance).value))
      return false;
    return scene_.visible(light.is_infinite() ? leave(from, sample->to_light)
                                              : segment(from, sample->origin, sample->to_light));
  }

  void walk_from_lights() {
    for (std::size_t i = 0; i < settings_.walks && !lights_.empty(); ++i) {
      const auto choice = scene_.sample_light(random_number());
      if (choice.light == nullptr) continue;
      const Vec2<T> origin = two();
      const auto start = choice.light->sample_emission(origin, two());
      if (start) follow(start->origin, start->direction, TransportMode::importance);
    }
  }

  /// The median distance between the vertices of subpaths.
  void measure() {
    std::vector<double> distances;
    for (const Vertex& vertex : vertices_)
      if (std::isfinite(vertex.distance)) distances.push_back(vertex.distance);
    if (distances.empty()) return;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle > 0.0) distance_ = *middle;
  }

  void check_hit(const Vertex& vertex) {
    const Point& point = vertex.hit.point;
    const V position(point.position), direction(vertex.ray.direction), normal(point.geometric_normal);
    const V along = position - V(vertex.ray.origin);
    const double rounding = 64.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) *
                            (glm::length(position) + glm::length(V(vertex.ray.origin)));
    findings_.count(Convention::hit_on_ray, glm::dot(along, direction) > -rounding &&
                                                glm::length(along - glm::dot(along, direction) * direction) <=
                                                    1e-3 * vertex.distance + rounding);
    const bool is_unit = detail::nearly(glm::length(normal), 1.0, 1e-3);
    findings_.count(Convention::hit_normal_unit,
                    is_unit && detail::nearly(glm::length(V(point.shading_normal)), 1.0, 1e-3));
    findings_.count(Convention::hit_normal_hemisphere, glm::dot(normal, V(point.shading_normal)) > 0.0);
    if (vertex.distance < 1e-2 * distance_) return;

    const auto nearer =
        scene_.intersect({vertex.ray.origin, vertex.ray.direction, static_cast<T>(0.5 * vertex.distance)});
    findings_.count(Convention::hit_range, !nearer.has_value());
    findings_.count(Convention::visible_true,
                    scene_.visible({vertex.ray.origin, vertex.ray.direction, static_cast<T>(0.5 * vertex.distance)}));
    if (!is_unit) return;
    check_slant(vertex, position, direction, normal);
    check_other_side(point, position, direction, normal);
    // A ray that leaves the point on either side.
    for (const double side : {1.0, -1.0}) {
      const Vec3<T> away(side *
                         Frame<double>::around(normal).to_world(square_to_cosine_hemisphere(Vec2<double>(two()))));
      const Ray<T> ray = leave(point, away);
      const auto next = scene_.intersect(ray);
      const bool is_grazing = std::abs(glm::dot(V(away), normal)) < 0.1;
      if (!is_grazing)
        findings_.count(Convention::hit_same_surface,
                        !next || glm::length(V(next->point.position) - V(ray.origin)) > 1e-5 * distance_);
    }
  }

  /// A hit beside this one must lie in the plane of the geometric normal.
  void check_slant(const Vertex& vertex, const V& position, const V& direction, const V& normal) {
    const Frame<double> frame = Frame<double>::around(direction);
    const double turn = 2.0 * pi<double> * uniform<double>(source_);
    const V beside =
        glm::normalize(direction + 2e-3 * (std::cos(turn) * frame.tangent + std::sin(turn) * frame.bitangent));
    const auto hit = scene_.intersect({vertex.ray.origin, Vec3<T>(beside)});
    if (!hit || std::abs(glm::dot(direction, normal)) < 0.2) return;
    const V step = V(hit->point.position) - position;
    if (glm::length(step) > 0.02 * vertex.distance || !(glm::length(step) > 1e-4 * vertex.distance)) return;
    findings_.count(Convention::hit_normal_slant, std::abs(glm::dot(glm::normalize(step), normal)) < 0.1);
  }

  /// The same point from the other side must have the same normal.
  void check_other_side(const Point& point, const V& position, const V& direction, const V& normal) {
    const auto next = scene_.intersect(leave(point, Vec3<T>(direction)));
    double beyond = 0.01 * distance_;
    if (next) beyond = std::min(beyond, 0.5 * glm::length(V(next->point.position) - position));
    if (beyond < 1e-3 * distance_ || std::abs(glm::dot(direction, normal)) < 0.2) return;
    const auto back = scene_.intersect({Vec3<T>(position + beyond * direction), Vec3<T>(-direction)});
    if (!back || glm::length(V(back->point.position) - position) > 0.02 * beyond) return;
    findings_.count(Convention::hit_normal_turned, glm::dot(V(back->point.geometric_normal), normal) > 0.0);
  }

  /// `visible` against `intersect`: between points that a ray joins, and between points taken at random.
  void check_visibility() {
    for (const Vertex& vertex : vertices_) {
      if (vertex.distance < 1e-2 * distance_) continue;
      const Vec3<T>& direction = vertex.ray.direction;
      const double slant = std::abs(glm::dot(V(vertex.hit.point.geometric_normal), V(direction)));
      const double start = std::abs(glm::dot(V(vertex.from.geometric_normal), V(direction)));
      const bool has_start_normal = glm::length(V(vertex.from.geometric_normal)) > 0.5;
      if (slant < 0.1 || (has_start_normal && start < 0.1)) continue;
      const double apart = glm::length(V(vertex.hit.point.position) - V(vertex.from.position));
      const Vec3<T> exact((V(vertex.hit.point.position) - V(vertex.from.position)) / apart);
      findings_.count(Convention::visible_true, scene_.visible(segment(vertex.from, vertex.hit.point, exact)));
    }
    for (std::size_t i = 0; i < settings_.walks && vertices_.size() > 1; ++i) {
      const auto any = [&]() -> const Point& {
        return vertices_[uniform_index(source_, static_cast<std::uint32_t>(vertices_.size()))].hit.point;
      };
      const Point &a = any(), &b = any();
      const V between = V(b.position) - V(a.position);
      const double length = glm::length(between);
      if (length < 1e-2 * distance_) continue;
      const V direction = between / length;
      if (std::abs(glm::dot(direction, V(a.geometric_normal))) < 0.1 ||
          std::abs(glm::dot(direction, V(b.geometric_normal))) < 0.1)
        continue;
      const Ray<T> ray = segment(a, b, Vec3<T>(direction));
      const auto hit = scene_.intersect(ray);
      // A hit close to either end may be found by one of the two and not by the other.
      if (hit) {
        const double at = glm::length(V(hit->point.position) - V(ray.origin));
        if (at < 0.01 * length || at > 0.99 * length) continue;
        findings_.count(Convention::visible_false, !scene_.visible(ray));
      } else {
        findings_.count(Convention::visible_true, scene_.visible(ray));
      }
    }
  }

  void check_surfaces() {
    const std::size_t stride = std::max<std::size_t>(1, vertices_.size() / settings_.surfaces);
    const std::size_t few = std::max<std::size_t>(1, stride / 16);
    for (std::size_t number = 0; number < vertices_.size(); number += few) {
      const Vertex& vertex = vertices_[number];
      const Point& point = vertex.hit.point;
      const V position(point.position);
      const Vec3<T> to_prev = -vertex.ray.direction;
      // As the engine does: the BSDF of a ray that arrives from `to_prev`.
      const auto bsdf_for = [&](const Vec3<T>& to) -> std::optional<Bsdf> {
        if (glm::length(V(to) - V(to_prev)) < 1e-9) return vertex.hit.bsdf;
        if (std::abs(glm::dot(V(to), V(point.geometric_normal))) < 0.05) return std::nullopt;
        const auto obstacle = scene_.intersect(leave(point, to));
        double beyond = 0.01 * distance_;
        if (obstacle) beyond = std::min(beyond, 0.5 * glm::length(V(obstacle->point.position) - position));
        if (beyond < 1e-4 * distance_) return std::nullopt;
        const auto hit = scene_.intersect({Vec3<T>(position + beyond * V(to)), -to});
        if (!hit || glm::length(V(hit->point.position) - position) > 0.02 * beyond) return std::nullopt;
        return hit->bsdf;
      };
      const bool is_chosen = number / few % 16 == 0;
      check_surface(bsdf_for, point, to_prev, source_, findings_, is_chosen ? settings_.samples : 0,
                    settings_.level / (4.0 * static_cast<double>(settings_.surfaces)));
    }
  }

  void check_lights() {
    std::vector<Point> receivers;
    for (std::size_t i = 0; i < vertices_.size() && receivers.size() < 64; i += 1 + vertices_.size() / 64) {
      // Halfway along a ray: a point that is not on the light itself.
      Point point{};
      const Vertex& vertex = vertices_[i];
      point.position = Vec3<T>((V(vertex.ray.origin) + V(vertex.hit.point.position)) / 2.0);
      receivers.push_back(point);
    }
    const std::size_t count = std::min(lights_.size(), settings_.most_lights);
    for (std::size_t i = 0; i < count; ++i)
      findings_.add(check_light(scene_, *lights_[i].second, std::span<const Point>(receivers), source_,
                                settings_.level / (2.0 * static_cast<double>(count)), settings_.samples));
  }

  const Sc& scene_;
  SceneCheckSettings settings_;
  Philox source_;
  Findings findings_;
  std::vector<Vertex> vertices_;
  std::vector<std::pair<std::size_t, const Light*>> lights_;
  double distance_ = 1.0;
};

/// Samples the scene and names the conventions that it breaks (`SceneChecker`).
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
