#pragma once

#include <optional>

#include "gmis/scene/fresnel.hpp"
#include "gmis/scene/microfacet.hpp"

namespace gmis::scene {

/// A rough interface between two dielectric media. Each facet reflects and refracts like smooth
/// glass [Walter et al. 2007, eq. 20 and 21]. Sampling draws facets that are visible from `to_prev`
/// [Heitz 2018].
template <std::floating_point T>
struct RoughDielectric {
  /// One lobe for one pair of directions. `value`, `forward` and `reverse` exclude the Fresnel
  /// factor of the facet.
  struct Lobe {
    T value = 0;    ///< f of importance [1/sr] without cosine; f of radiance is 1/eta² of it for the refracting lobe
    T forward = 0;  ///< density per steradian of `to_next` given `to_prev`: draw a visible facet, then use this lobe
    T reverse = 0;  ///< density per steradian of `to_prev` given `to_next`
    T reflectance = 1;  ///< Fresnel reflectance of the facet
  };

  Ggx<T> ggx;      ///< distribution of the microfacets
  T eta;           ///< index on the other side divided by the index on the side of `to_prev`
  Vec3<T> normal;  ///< unit, on the side of `to_prev`

  /// The reflecting lobe, for two directions on one side. `prev` and `next` are their cosines > 0
  /// with the normal.
  [[nodiscard]] Lobe reflection(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    const Vec3<T> sum = to_prev + to_next;
    const T length = glm::length(sum);  // twice the cosine at the facet
    const T distribution = ggx.distribution(sum * (T(1) / length), normal) / T(4);
    const T lambda_prev = ggx.lambda(prev);
    const T lambda_next = ggx.lambda(next);
    return {distribution * ggx.visibility(lambda_prev, lambda_next) / (prev * next),
            distribution * ggx.visibility(lambda_prev) / prev, distribution * ggx.visibility(lambda_next) / next,
            fresnel_dielectric(length / T(2), eta).reflectance};
  }

  /// The refracting lobe, for directions on different sides. `prev` and `next` are their cosines >
  /// 0 with the normal of their side. All values are 0 when no facet refracts one direction into
  /// the other.
  [[nodiscard]] Lobe transmission(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    const Vec3<T> sum = to_prev + to_next * eta;
    const T length_squared = glm::dot(sum, sum);
    if (!(length_squared > T(0))) return {};
    const T side = prev > eta * next ? T(1) : T(-1);  // the facet's normal is on the side of `to_prev`
    const Vec3<T> half = sum * (side / std::sqrt(length_squared));
    const T facet_prev = glm::dot(half, to_prev);
    const T facet_next = -glm::dot(half, to_next);
    if (!(facet_prev > T(0) && facet_next > T(0))) return {};  // no facet refracts this way
    // d(half)/d(to_next) = eta² · facet_next / |sum|²; d(half)/d(to_prev) = facet_prev / |sum|².
    const T distribution = ggx.distribution(half, normal) * facet_prev * facet_next / length_squared;
    const T lambda_prev = ggx.lambda(prev);
    const T lambda_next = ggx.lambda(next);
    const T eta2 = eta * eta;
    return {eta2 * distribution * ggx.visibility(lambda_prev, lambda_next) / (prev * next),
            eta2 * distribution * ggx.visibility(lambda_prev) / prev, distribution * ggx.visibility(lambda_next) / next,
            fresnel_dielectric(facet_prev, eta).reflectance};
  }

  /// Normal of a facet that is visible from `to_prev`, in world space.
  [[nodiscard]] Vec3<T> sample_facet(const Vec3<T>& to_prev, const Vec2<T>& uv) const noexcept {
    const auto frame = Frame<T>::around(normal);
    return frame.to_world(ggx.sample_visible(frame.to_local(to_prev), uv));
  }
  /// Reflection and refraction at a facet with the normal `half`.
  [[nodiscard]] DielectricFresnel<T> fresnel_at(const Vec3<T>& to_prev, const Vec3<T>& half) const noexcept {
    return fresnel_dielectric(glm::dot(half, to_prev), eta);
  }
  /// The refracted unit direction at a facet with the normal `half`. `cos_transmitted` is that of
  /// `fresnel_at`; the facet must not reflect totally.
  [[nodiscard]] Vec3<T> refracted(const Vec3<T>& to_prev, const Vec3<T>& half, T cos_transmitted) const noexcept {
    return glm::normalize(half * (glm::dot(half, to_prev) / eta - cos_transmitted) - to_prev * (T(1) / eta));
  }
};

}  // namespace gmis::scene
