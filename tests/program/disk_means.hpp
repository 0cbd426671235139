#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/scene_like.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/transport/techniques/merge.hpp"

namespace gmis_test {

/// A scene in which path tracing makes what photon mapping makes on the mean, without a photon: the
/// light that arrives at a random point x' of the disk around the first hit x of a camera ray goes
/// through the BSDF at x. A merge at x has the mean
///
///     1/(π r²) ∫ ∫ f L(x', ω) |n'·ω| |n_s·ω| / |n·ω| dω dA(x')
///
/// over the points x' nearer than r that `Merge` does not leave out, f the BSDF at x, n' the
/// geometric normal at x', n and n_s the normals at x. x' is drawn on lines along n through the
/// disk, with the density |n'·n| / (π r²) per area.
///
/// Camera rays are those that start in the plane of the pinhole or of the lens, or in that of
/// parallel rays: no surface may lie there.
template <gmis::Scene Sc>
class DiskMeans : public gmis::SceneLike<Sc> {
 public:
  using S = typename Sc::Spectrum;
  using T = gmis::ScalarOf<S>;
  using V = gmis::Vec3<T>;
  using SurfacePoint = gmis::SurfacePoint<T>;

  class Bsdf {
   public:
    using Spectrum = S;
    /// The BSDF at x, whose geometric normal is `normal`, for light that arrives at x', times a
    /// factor.
    Bsdf(const typename Sc::Bsdf& own, T factor, const V& normal, const V& normal_there)
        : own_(own), factor_(factor), normal_(normal), normal_there_(normal_there) {}

    [[nodiscard]] gmis::BsdfValue<S> evaluate(const V& to_prev, const V& to_next, gmis::TransportMode mode) const {
      auto f = own_.evaluate(to_prev, to_next, mode);
      f.value = f.value * factor(to_next);
      return f;
    }
    [[nodiscard]] std::optional<gmis::ScatterSample<S>> sample(const V& to_prev, T u, const gmis::Vec2<T>& uv,
                                                               gmis::TransportMode mode) const {
      auto drawn = own_.sample(to_prev, u, uv, mode);
      if (drawn) drawn->weight = drawn->weight * factor(drawn->to_next);
      return drawn;
    }
    [[nodiscard]] bool is_purely_delta() const { return own_.is_purely_delta(); }
    [[nodiscard]] S albedo() const { return own_.albedo(); }

   private:
    [[nodiscard]] T factor(const V& to_next) const {
      const T here = std::abs(glm::dot(normal_, to_next));
      return here > T(0) ? factor_ * std::abs(glm::dot(normal_there_, to_next)) / here : T(0);
    }

    typename Sc::Bsdf own_;
    T factor_;
    V normal_, normal_there_;
  };
  using Hit = gmis::Hit<T, Bsdf, typename Sc::Light>;

  DiskMeans(const Sc& scene, T radius) : gmis::SceneLike<Sc>(scene), radius_(radius) {
    // Through the centre of the film and that of the lens: along the axis of the camera.
    const auto axis = scene.camera().sample_ray(scene.camera().resolution() / 2, {T(0), T(0)}, {T(0.5), T(0.5)});
    start_ = axis->origin.position;
    axis_ = axis->direction;
  }

  [[nodiscard]] std::optional<Hit> intersect(const gmis::Ray<T>& ray) const {
    const auto hit = this->own().intersect(ray);
    if (!hit) return std::nullopt;
    const SurfacePoint& here = hit->point;
    const V n = here.geometric_normal;
    if (std::abs(glm::dot(ray.origin - start_, axis_)) > T(1e-3))
      return Hit{here, Bsdf(hit->bsdf, T(1), n, n), hit->light};
    // Numbers that every camera ray has for itself.
    const auto bits = [](T x) { return std::bit_cast<std::uint32_t>(x); };
    gmis::Philox source(std::uint64_t{bits(ray.direction.x)} << 32U | bits(ray.origin.x),
                        bits(ray.direction.y) ^ std::rotl(bits(ray.origin.y), 16),
                        bits(ray.direction.z) ^ std::rotl(bits(ray.origin.z), 16));
    const std::vector<SurfacePoint> points = points_on_line(here, source);
    if (points.empty()) return Hit{here, Bsdf(hit->bsdf, T(0), n, n), hit->light};
    const auto count = static_cast<T>(points.size());
    auto there = points[std::min(points.size() - 1, static_cast<std::size_t>(gmis::uniform<T>(source) * count))];
    const T density = std::abs(glm::dot(there.geometric_normal, n)) / count;
    there.shading_normal = here.shading_normal;
    return Hit{there, Bsdf(hit->bsdf, T(1) / density, n, there.geometric_normal), hit->light};
  }

 private:
  /// The points that may be merged with `here` on a random line through the disk.
  template <class Source>
  [[nodiscard]] std::vector<SurfacePoint> points_on_line(const SurfacePoint& here, Source& source) const {
    const V n = here.geometric_normal;
    const V s = glm::normalize(std::abs(n.x) > T(0.5) ? V(n.y, -n.x, 0) : V(0, n.z, -n.y)), t = glm::cross(n, s);
    const T distance = std::sqrt(gmis::uniform<T>(source)), angle = 2 * gmis::pi<T> * gmis::uniform<T>(source);
    const T half = radius_ * std::sqrt(1 - distance * distance);
    const V start = here.position + radius_ * distance * (std::cos(angle) * s + std::sin(angle) * t) + half * n;
    std::vector<SurfacePoint> points;
    gmis::Ray<T> line{start, -n, 2 * half};
    while (const auto hit = this->own().intersect(line)) {
      SurfacePoint there = hit->point;
      if (glm::dot(there.geometric_normal, n) < T(0)) {
        there.geometric_normal = -there.geometric_normal;
        there.shading_normal = -there.shading_normal;
      }
      const T least_height = static_cast<T>(gmis::Merge::least_height) * radius_;
      if (glm::dot(there.geometric_normal, n) >= static_cast<T>(gmis::Merge::least_normal_cosine) &&
          !gmis::Merge::is_beside(there.position - here.position, n, there.geometric_normal,
                                  least_height * least_height))
        points.push_back(there);
      line = gmis::leave(hit->point, V(-n));
      line.t_max = 2 * half - glm::dot(start - line.origin, n);
      if (!(line.t_max > T(0))) break;
    }
    return points;
  }

  T radius_;
  V start_, axis_;  ///< of the camera
};

}  // namespace gmis_test
