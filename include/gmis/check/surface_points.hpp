#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"

namespace gmis {

/// A BSDF with the optional member `check_group()`: a number that surfaces share whose BSDF runs
/// through the same code, such as the number of a material. Adapter checks then test these surfaces
/// by themselves. Without it surfaces are grouped by observed properties: delta and narrow lobes,
/// the albedo, whether they emit.
template <class B>
concept BsdfWithCheckGroup = Bsdf<B> && requires(const B& bsdf) {
  { bsdf.check_group() } -> std::convertible_to<std::uint64_t>;
};

namespace detail {

/// A hit, with the ray that found it.
template <Scene Sc>
struct CheckedHit {
  using T = ScalarOf<typename Sc::Spectrum>;
  Ray<T> ray;
  SurfacePoint<T> from;
  Hit<T, typename Sc::Bsdf, typename Sc::Light> hit;
  double distance;
  std::size_t group;
};

/// Key of a surface: surfaces with the same key are tested together.
template <Bsdf B, std::floating_point T, UniformSource Source>
[[nodiscard]] std::uint64_t surface_key(const B& bsdf, const Vec3<T>& to_prev, bool emits, Source& source) {
  if constexpr (BsdfWithCheckGroup<B>) {
    return static_cast<std::uint64_t>(bsdf.check_group());
  } else {
    using S = typename B::Spectrum;
    std::uint64_t key = emits ? 1 : 0;
    const auto append = [&key](std::uint64_t value, std::uint64_t count) { key = key * count + value; };
    append(bsdf.is_purely_delta() ? 1 : 0, 2);
    append(reflects_only(bsdf) ? 1 : 0, 2);
    append(has_narrow_lobe(bsdf) ? 1 : 0, 2);
    const S albedo = bsdf.albedo();
    const double largest = static_cast<double>(max_channel(albedo));
    append(static_cast<std::uint64_t>(std::clamp(4.0 * largest, 0.0, 4.0)), 5);
    for (int i = 0; i < std::min(3, SpectrumTraits<S>::channel_count); ++i)
      append(2.0 * static_cast<double>(SpectrumTraits<S>::channel(albedo, i)) > largest ? 1 : 0, 2);
    // How narrow: the length of the mean direction of some draws, 2/3 for a diffuse lobe.
    Vec3<double> sum(0.0);
    double count = 0.0;
    std::uint64_t has_delta = 0;
    for (int i = 0; i < 24; ++i) {
      const T u = uniform<T>(source), v = uniform<T>(source);
      const auto drawn = bsdf.sample(to_prev, u, {v, uniform<T>(source)}, TransportMode::radiance);
      if (!drawn) continue;
      has_delta = has_delta != 0 || drawn->is_delta ? 1 : 0;
      if (drawn->is_delta) continue;
      sum += Vec3<double>(drawn->to_next);
      count += 1.0;
    }
    append(has_delta, 2);
    const double length = count < 8.0 ? 0.0 : glm::length(sum) / count;
    append(length < 0.8 ? 0 : length < 0.95 ? 1 : 2, 3);
    return key;
  }
}

/// Points on the surfaces of a scene, as subpaths from the camera and from the lights meet them,
/// and rays between surfaces; by groups of surfaces that are alike, with at least `points` points
/// in each group that can be found.
template <Scene Sc>
class SurfacePoints {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;
  using Light = typename Sc::Light;
  using Point = SurfacePoint<T>;
  static constexpr std::size_t most_groups = 32;

  /// `depth`: edges of a subpath.
  SurfacePoints(const Sc& scene, std::size_t points, int depth, Philox& source)
      : scene_(scene), points_(points), depth_(depth), source_(source) {}

  void walk_from_camera(std::size_t walks) {
    const glm::ivec2 size = scene_.camera().resolution();
    for (std::size_t i = 0; i < walks; ++i) {
      const Vec2<T> place = two();
      const glm::ivec2 pixel = glm::min(glm::ivec2(Vec2<double>(place) * Vec2<double>(size)), size - 1);
      const Vec2<T> uv = two();
      if (const auto ray = scene_.camera().sample_ray(pixel, uv, two()))
        follow(ray->origin, ray->direction, TransportMode::radiance);
    }
  }
  void walk_from_light(const Light& light) {
    const Vec2<T> origin = two();
    if (const auto start = light.sample_emission(origin, two()))
      follow(start->origin, start->direction, TransportMode::importance);
  }
  /// Rays from any surface to points of a light from which light starts: a lamp may be one of many
  /// that look alike.
  void seek_light(const Light& light) {
    constexpr int rays = 16;
    for (int i = 0; i < rays && !hits_.empty(); ++i) {
      const Vec2<T> origin = two();
      const auto start = light.sample_emission(origin, two());
      if (!start) continue;
      const Vec3<double> normal(start->origin.geometric_normal), at(start->origin.position);
      if (light.is_infinite() || !(glm::length(normal) > 0.5)) return;  // no surface
      const auto [from, offset] = surface_before(at, normal);
      if (glm::dot(offset, normal) < 0.0) shoot(from, Vec3<T>(glm::normalize(offset)), always);
    }
  }
  /// Looks for rare surfaces by rays from any surface: in random directions, kept where few hits
  /// are known; to places with few hits, which may be small objects; and to groups with too few
  /// points. About `rays` rays of each of the first two kinds.
  void seek_rare(std::size_t rays) {
    measure();
    if (hits_.empty()) return;
    cells_.clear();
    for (std::size_t i = 0; i < hits_.size(); ++i) cells_[cell_of(hits_[i].hit.point, hits_[i].group)].push_back(i);
    for (std::size_t i = 0; i < rays; ++i) {
      const CheckedHit<Sc> from = any();
      const Vec3<double> normal(from.hit.point.geometric_normal);
      const double came_from = glm::dot(Vec3<double>(from.ray.direction), normal) < 0.0 ? 1.0 : -1.0;
      const double side = uniform<double>(source_) < 0.8 ? came_from : -came_from;
      const Vec3<double> local = square_to_cosine_hemisphere(Vec2<double>(two()));
      shoot(from.hit.point, Vec3<T>(side * Frame<double>::around(normal).to_world(local)),
            [&](std::size_t group, const Point& at) {
              return counts_[group] < points_ || cells_[cell_of(at, group)].size() < 2;
            });
    }
    seek_places(rays);
    for (std::size_t group = 0; group < most_groups; ++group)
      if (counts_[group] > 0) seek_group(group);
  }

  [[nodiscard]] std::span<const CheckedHit<Sc>> hits() const noexcept { return hits_; }
  /// Indices in `hits()` of at most `most` hits of this group, evenly spaced among them.
  [[nodiscard]] std::vector<std::size_t> of_group(std::size_t group, std::size_t most) const {
    std::vector<std::size_t> all, chosen;
    for (std::size_t i = 0; i < hits_.size(); ++i)
      if (hits_[i].group == group) all.push_back(i);
    const std::size_t count = std::min(most, all.size());
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
    return chosen;
  }
  /// Median distance between the vertices of subpaths, in scene units; 1 where there are none.
  [[nodiscard]] double distance() const noexcept { return distance_; }

 private:
  static constexpr auto always = [](std::size_t, const Point&) { return true; };

  [[nodiscard]] Vec2<T> two() {
    const T u = uniform<T>(source_);
    return {u, uniform<T>(source_)};
  }
  [[nodiscard]] const CheckedHit<Sc>& any() {
    return hits_[uniform_index(source_, static_cast<std::uint32_t>(hits_.size()))];
  }

  /// Follows a subpath and keeps its vertices.
  void follow(Point from, Vec3<T> direction, TransportMode mode) {
    for (int depth = 0; depth < depth_; ++depth) {
      const auto hit = shoot(from, direction, always);
      if (!hit) return;
      const T u = uniform<T>(source_);
      const auto sample = hit->bsdf.sample(-direction, u, two(), mode);
      if (!sample || !(glm::length(sample->to_next) > T(0.9) && glm::length(sample->to_next) < T(1.1))) return;
      from = hit->point;
      direction = sample->to_next;
    }
  }
  /// The hit of a ray, kept where `is_wanted(group, point)`.
  template <class IsWanted>
  auto shoot(const Point& from, const Vec3<T>& direction, const IsWanted& is_wanted)
      -> decltype(std::declval<const Sc&>().intersect(std::declval<Ray<T>>())) {
    const Ray<T> ray = leave(from, direction);
    auto hit = scene_.intersect(ray);
    if (!hit) return hit;
    const std::size_t group = group_of(*hit, direction);
    if (!is_wanted(group, hit->point)) return hit;
    ++counts_[group];
    cells_[cell_of(hit->point, group)].push_back(hits_.size());
    const double distance = glm::length(Vec3<double>(hit->point.position) - Vec3<double>(ray.origin));
    hits_.push_back({ray, from, *hit, distance, group});
    return hit;
  }
  using Cell = std::array<long, 5>;
  /// Where and how a surface lies: a cube of space, a tenth of the median distance wide, the axis
  /// nearest to the normal, the group.
  [[nodiscard]] Cell cell_of(const Point& point, std::size_t group) const {
    const auto place = [&](T x) {
      return static_cast<long>(std::clamp(std::floor(static_cast<double>(x) / (0.1 * distance_)), -1e9, 1e9));
    };
    const Vec3<T>& n = point.geometric_normal;
    const Vec3<T> size = glm::abs(n);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return {place(point.position.x), place(point.position.y), place(point.position.z),
            2 * axis + (n[axis] > T(0) ? 1 : 0), static_cast<long>(group)};
  }
  template <class H>
  [[nodiscard]] std::size_t group_of(const H& hit, const Vec3<T>& direction) {
    const std::uint64_t key = surface_key(hit.bsdf, Vec3<T>(-direction), hit.light != nullptr, source_);
    const auto [place, is_new] = groups_.try_emplace(key, std::min(groups_.size(), most_groups - 1));
    return place->second;
  }
  /// A point of any surface, if possible on the side of `target` that `normal` points to, and the
  /// vector from it to `target`.
  [[nodiscard]] std::pair<Point, Vec3<double>> surface_before(const Vec3<double>& target, const Vec3<double>& normal) {
    Point from = any().hit.point;
    Vec3<double> offset = target - Vec3<double>(from.position);
    for (int i = 0; i < 8 && glm::dot(offset, normal) >= 0.0; ++i) {
      from = any().hit.point;
      offset = target - Vec3<double>(from.position);
    }
    return {from, offset};
  }
  /// A ray from any surface to a point beside that of a hit.
  template <class IsWanted>
  void aim(std::size_t target, double spread, const IsWanted& is_wanted) {
    const Vec3<double> beside = spread * uniform<double>(source_) * square_to_sphere(Vec2<double>(two()));
    const Vec3<double> aimed_at = Vec3<double>(hits_[target].hit.point.position) + beside;
    const Vec3<double> normal(hits_[target].hit.point.geometric_normal);
    const double side = glm::dot(Vec3<double>(hits_[target].ray.direction), normal);
    // From a surface that lies on the side from which the hit was found.
    const auto [from, offset] = surface_before(aimed_at, side < 0.0 ? normal : -normal);
    if (glm::length(offset) > 1e-3 * distance_) shoot(from, Vec3<T>(glm::normalize(offset)), is_wanted);
  }
  /// Rays to places with few hits.
  void seek_places(std::size_t rays) {
    constexpr std::size_t enough = 7, rounds = 4;
    for (std::size_t round = 0; round < rounds; ++round) {
      std::vector<std::size_t> targets;
      for (const auto& [cell, known] : cells_)
        for (std::size_t i = known.size(); i < enough; ++i) targets.push_back(known[i % known.size()]);
      for (std::size_t i = 0; i < targets.size(); ++i)
        std::swap(targets[i], targets[i + uniform_index(source_, static_cast<std::uint32_t>(targets.size() - i))]);
      targets.resize(std::min(targets.size(), rays / rounds));
      for (const std::size_t target : targets)
        aim(target, 0.01 * distance_,
            [&](std::size_t group, const Point& at) { return cells_[cell_of(at, group)].size() < 2 * enough; });
    }
  }
  /// Rays to points beside the known ones of this group.
  void seek_group(std::size_t group) {
    for (std::size_t i = 0; i < 12 * points_ && counts_[group] < points_; ++i) {
      const std::vector<std::size_t> known = of_group(group, points_);
      const std::size_t target = known[uniform_index(source_, static_cast<std::uint32_t>(known.size()))];
      aim(target, std::min(0.02 * distance_, 0.2 * hits_[target].distance),
          [&](std::size_t other, const Point&) { return other == group; });
    }
  }
  void measure() {
    std::vector<double> distances;
    for (const CheckedHit<Sc>& hit : hits_)
      if (std::isfinite(hit.distance)) distances.push_back(hit.distance);
    if (distances.empty()) return;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle > 0.0) distance_ = *middle;
  }

  const Sc& scene_;
  std::size_t points_;
  int depth_;
  Philox& source_;
  std::vector<CheckedHit<Sc>> hits_;
  std::map<std::uint64_t, std::size_t> groups_;
  std::map<Cell, std::vector<std::size_t>> cells_;  ///< indices of the hits in each
  std::array<std::size_t, most_groups> counts_{};
  double distance_ = 1.0;
};

}  // namespace detail

}  // namespace gmis
