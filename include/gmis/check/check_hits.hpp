#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "gmis/check/compare.hpp"
#include "gmis/check/findings.hpp"
#include "gmis/check/surface_points.hpp"
#include "gmis/core/transmittance.hpp"

namespace gmis::detail {

/// Checks `intersect`, `visible` and `transmittance` of a scene at hits: normals, offsets, ranges
/// of rays.
template <Scene Sc>
class HitCheck {
 public:
  using T = ScalarOf<typename Sc::Spectrum>;
  using Point = SurfacePoint<T>;

  HitCheck(const Sc& scene, double distance, Philox& source, Findings& findings)
      : scene_(scene), distance_(distance), source_(source), findings_(findings) {}

  /// All conventions of one hit.
  void check(const CheckedHit<Sc>& at) {
    const Point& point = at.hit.point;
    const V position(point.position), direction(at.ray.direction), normal(point.geometric_normal);
    findings_.look_at(at.group, {position, -direction, V(0)});
    const V along = position - V(at.ray.origin);
    const double rounding = 64.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) *
                            (glm::length(position) + glm::length(V(at.ray.origin)));
    const double beside = glm::length(along - glm::dot(along, direction) * direction);
    findings_.count(Convention::hit_on_ray,
                    glm::dot(along, direction) > -rounding && beside <= 1e-3 * at.distance + rounding, beside, 0.0);
    const bool is_unit = nearly(glm::length(normal), 1.0, 1e-3);
    findings_.count(Convention::hit_normal_unit, is_unit && nearly(glm::length(V(point.shading_normal)), 1.0, 1e-3),
                    glm::length(is_unit ? V(point.shading_normal) : normal), 1.0);
    findings_.count(Convention::hit_normal_hemisphere, glm::dot(normal, V(point.shading_normal)) > 0.0);
    if (at.distance < 1e-2 * distance_) return;

    const Ray<T> half{at.ray.origin, at.ray.direction, static_cast<T>(0.5 * at.distance)};
    findings_.count(Convention::hit_range, !scene_.intersect(half).has_value());
    findings_.count(Convention::visible_true, scene_.visible(half));
    if (!is_unit) return;
    check_visible(at);
    check_transmittance(at);
    check_slant(at, position, direction, normal);
    check_other_side(point, position, direction, normal);
    for (const double side : {1.0, -1.0}) check_leaving(point, normal, side);
  }

  /// `visible` against `intersect` between two points.
  void check_pair(const CheckedHit<Sc>& first, const CheckedHit<Sc>& second) {
    const Point &a = first.hit.point, &b = second.hit.point;
    const V between = V(b.position) - V(a.position);
    const double length = glm::length(between);
    if (length < 1e-2 * distance_) return;
    const V direction = between / length;
    if (std::abs(glm::dot(direction, V(a.geometric_normal))) < 0.1 ||
        std::abs(glm::dot(direction, V(b.geometric_normal))) < 0.1)
      return;
    const Ray<T> ray = segment(a, b, Vec3<T>(direction));
    const auto hit = scene_.intersect(ray);
    findings_.look_at(first.group, {V(a.position), V(0), direction});
    if (!hit) {
      findings_.count(Convention::visible_true, scene_.visible(ray));
      return;
    }
    // A hit close to either end may be found by one of the two and not by the other.
    const double at = glm::length(V(hit->point.position) - V(ray.origin));
    if (at >= 0.01 * length && at <= 0.99 * length) findings_.count(Convention::visible_false, !scene_.visible(ray));
  }

 private:
  using V = Vec3<double>;

  /// From the start of the ray the hit is seen, and the next surface behind it is not.
  void check_visible(const CheckedHit<Sc>& at) {
    const V direction(at.ray.direction);
    const double slant = std::abs(glm::dot(V(at.hit.point.geometric_normal), direction));
    if (slant < 0.1) return;
    const V start(at.from.geometric_normal);
    if (glm::length(start) > 0.5 && std::abs(glm::dot(start, direction)) < 0.1) return;
    const auto is_seen = [&](const Point& point) {
      const V offset = V(point.position) - V(at.from.position);
      return scene_.visible(segment(at.from, point, Vec3<T>(glm::normalize(offset))));
    };
    findings_.count(Convention::visible_true, is_seen(at.hit.point));
    const auto behind = scene_.intersect(leave(at.hit.point, at.ray.direction));
    if (behind && glm::length(V(behind->point.position) - V(at.hit.point.position)) > 1e-2 * distance_)
      findings_.count(Convention::visible_false, !is_seen(behind->point));
  }
  void check_transmittance(const CheckedHit<Sc>& at) {
    if constexpr (SceneWithAbsorption<Sc>) {
      using S = typename Sc::Spectrum;
      if (!scene_.has_absorption()) return;
      const T length = static_cast<T>(at.distance);
      const S there = transmittance_between(scene_, {at.ray.origin, at.ray.direction, length}, at.from, at.hit.point);
      const S back =
          transmittance_between(scene_, leave(at.hit.point, Vec3<T>(-at.ray.direction), length), at.hit.point, at.from);
      for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i) {
        const double a = static_cast<double>(SpectrumTraits<S>::channel(there, i)),
                     b = static_cast<double>(SpectrumTraits<S>::channel(back, i));
        findings_.count(Convention::transmittance, a >= 0.0 && a <= 1.0 + 1e-6 && std::abs(a - b) <= 0.02, a, b);
      }
    }
  }

  /// Hits on either side of this one must join to a chord in the plane of the geometric normal.
  void check_slant(const CheckedHit<Sc>& at, const V& position, const V& direction, const V& normal) {
    if (std::abs(glm::dot(direction, normal)) < 0.2) return;
    const Frame<double> frame = Frame<double>::around(direction);
    const double turn = 2.0 * pi<double> * uniform<double>(source_);
    const V aside = 2e-3 * (std::cos(turn) * frame.tangent + std::sin(turn) * frame.bitangent);
    const auto near_hit = [&](const V& towards) -> std::optional<V> {
      const auto hit = scene_.intersect({at.ray.origin, Vec3<T>(glm::normalize(towards))});
      if (!hit || glm::length(V(hit->point.position) - position) > 0.02 * at.distance) return std::nullopt;
      return V(hit->point.position);
    };
    const auto one = near_hit(direction + aside), other = near_hit(direction - aside);
    if (!one || !other) return;
    const V step = *one - *other;
    if (!(glm::length(step) > 1e-4 * at.distance)) return;
    // At a step or an edge the three hits are not in line.
    const V aside_of_chord = glm::cross(0.5 * (*one + *other) - position, glm::normalize(step));
    if (glm::length(aside_of_chord) > 0.04 * glm::length(step)) return;
    const double slant = std::abs(glm::dot(glm::normalize(step), normal));
    findings_.count(Convention::hit_normal_slant, slant < 0.2, slant, 0.0);
  }
  /// The same point from the other side must have the same normal.
  void check_other_side(const Point& point, const V& position, const V& direction, const V& normal) {
    if (std::abs(glm::dot(direction, normal)) < 0.2) return;
    const auto next = scene_.intersect(leave(point, Vec3<T>(direction)));
    double beyond = 0.01 * distance_;
    if (next) beyond = std::min(beyond, 0.5 * glm::length(V(next->point.position) - position));
    if (beyond < 1e-3 * distance_) return;
    const auto back = scene_.intersect({Vec3<T>(position + beyond * direction), Vec3<T>(-direction)});
    if (!back || glm::length(V(back->point.position) - position) > 0.02 * beyond) return;
    const double cosine = glm::dot(V(back->point.geometric_normal), normal);
    // At the edge of a leaf its two sides are as near, but do not lie in one plane.
    if (std::abs(cosine) > 1.0 - 1e-5) findings_.count(Convention::hit_normal_turned, cosine > 0.0);
  }
  /// A ray that leaves the point on this side must not meet the surface again at once.
  void check_leaving(const Point& point, const V& normal, double side) {
    const T u = uniform<T>(source_);
    const V local = square_to_cosine_hemisphere(Vec2<double>(Vec2<T>(u, uniform<T>(source_))));
    if (local.z < 0.1) return;
    const Ray<T> ray = leave(point, Vec3<T>(side * Frame<double>::around(normal).to_world(local)));
    const auto next = scene_.intersect(ray);
    const double away = next ? glm::length(V(next->point.position) - V(ray.origin)) : distance_;
    // In a corner, and near the edge of a leaf, another surface may lie that near.
    const bool is_same = next && away <= 1e-5 * distance_ && glm::dot(V(next->point.geometric_normal), normal) > 0.9;
    findings_.count(Convention::hit_same_surface, !is_same, away, distance_);
  }

  const Sc& scene_;
  double distance_;
  Philox& source_;
  Findings& findings_;
};

}  // namespace gmis::detail
