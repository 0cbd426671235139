#pragma once

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
///     1/(π r²) ∫ ∫ f(x, ω) L(x', ω) |n'·ω| |n_s·ω| / |n·ω| dω dA(x'), |x' − x| < r,
///
/// n' the geometric normal at x', n and n_s those at x, without the points that `Merge` leaves out.
/// x' is drawn on lines along n through the disk, with the density |n'·n| / (π r²) per area. All
/// rays that start at the pinhole are camera rays.
template <gmis::Scene Sc>
class DiskMeans : public gmis::SceneLike<Sc> {
 public:
  using S = typename Sc::Spectrum;
  using T = gmis::ScalarOf<S>;
  using V = gmis::Vec3<T>;

  class Bsdf {
   public:
    using Spectrum = S;
    explicit Bsdf(const typename Sc::Bsdf& own) : own_(own) {}
    /// The BSDF at x for light that arrives at x'. With a factor of 0 no light goes through.
    Bsdf(const typename Sc::Bsdf& own, T factor, const V& normal, const V& normal_there)
        : own_(own), factor_(factor), normal_(normal), normal_there_(normal_there), is_moved_(true) {}

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
      if (!is_moved_) return T(1);
      const T here = std::abs(glm::dot(normal_, to_next));
      return here > T(0) ? factor_ * std::abs(glm::dot(normal_there_, to_next)) / here : T(0);
    }

    typename Sc::Bsdf own_;
    T factor_ = T(1);
    V normal_{0}, normal_there_{0};
    bool is_moved_ = false;
  };
  using Hit = gmis::Hit<T, Bsdf, typename Sc::Light>;

  DiskMeans(const Sc& scene, T radius)
      : gmis::SceneLike<Sc>(scene),
        radius_(radius),
        pinhole_(scene.camera().sample_ray({0, 0}, {T(0.5), T(0.5)}, {T(0.5), T(0.5)})->origin.position) {}

  [[nodiscard]] std::optional<Hit> intersect(const gmis::Ray<T>& ray) const {
    auto hit = this->own().intersect(ray);
    if (!hit) return std::nullopt;
    if (ray.origin != pinhole_) return Hit{hit->point, Bsdf(hit->bsdf), hit->light};
    // Numbers that every camera ray has for itself.
    gmis::Philox source(std::bit_cast<std::uint32_t>(ray.direction.x), std::bit_cast<std::uint32_t>(ray.direction.y),
                        std::bit_cast<std::uint32_t>(ray.direction.z), 0);
    const gmis::SurfacePoint<T> here = hit->point;
    const std::vector<gmis::SurfacePoint<T>> points = points_on_line(here, source);
    if (points.empty()) return Hit{here, Bsdf(hit->bsdf, T(0), here.geometric_normal, here.geometric_normal), nullptr};
    const auto count = static_cast<T>(points.size());
    auto there = points[std::min(points.size() - 1, static_cast<std::size_t>(gmis::uniform<T>(source) * count))];
    const V normal = there.geometric_normal;
    there.shading_normal = here.shading_normal;
    return Hit{
        there,
        Bsdf(hit->bsdf, count / std::abs(glm::dot(normal, here.geometric_normal)), here.geometric_normal, normal),
        hit->light};
  }

 private:
  /// The points that may be merged with `here` on a random line through the disk.
  template <class Source>
  [[nodiscard]] std::vector<gmis::SurfacePoint<T>> points_on_line(const gmis::SurfacePoint<T>& here,
                                                                  Source& source) const {
    const V n = here.geometric_normal;
    const V s = glm::normalize(std::abs(n.x) > T(0.5) ? V(n.y, -n.x, 0) : V(0, n.z, -n.y)), t = glm::cross(n, s);
    const T distance = std::sqrt(gmis::uniform<T>(source)), angle = 2 * gmis::pi<T> * gmis::uniform<T>(source);
    const T half = radius_ * std::sqrt(1 - distance * distance);
    const V start = here.position + radius_ * distance * (std::cos(angle) * s + std::sin(angle) * t) + half * n;
    std::vector<gmis::SurfacePoint<T>> points;
    gmis::Ray<T> line{start, -n, 2 * half};
    while (const auto hit = this->own().intersect(line)) {
      gmis::SurfacePoint<T> there = hit->point;
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
  V pinhole_;
};

}  // namespace gmis_test
