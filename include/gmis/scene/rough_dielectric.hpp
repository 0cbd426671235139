#pragma once

#include <optional>

#include "gmis/scene/fresnel.hpp"
#include "gmis/scene/microfacet.hpp"

namespace gmis::scene {

/// A rough interface between two media: every visible facet reflects and refracts like smooth glass
/// [Walter et al. 2007, eq. 20 and 21]. Facets are drawn from those visible from `to_prev` [Heitz 2018].
template <std::floating_point T>
struct RoughDielectric {
  /// What one lobe makes of a pair of directions, facet by facet: Fresnel's factor is left out of the first three.
  struct Lobe {
    T value = 0;    ///< f for importance [1/sr] without cosine; for radiance a refracting lobe has 1/eta² of it
    T forward = 0;  ///< densities per steradian of drawing a visible facet and then this lobe
    T reverse = 0;
    T reflectance = 1;  ///< of the facet
  };

  Ggx<T> ggx;
  T eta;           ///< index on the other side over that on the side of `to_prev`
  Vec3<T> normal;  ///< unit, on the side of `to_prev`

  /// Both on one side, at the cosines `prev` and `next` > 0.
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

  /// On two sides, `prev` and `next` > 0 the cosines with the normal of each side.
  [[nodiscard]] Lobe transmission(const Vec3<T>& to_prev, const Vec3<T>& to_next, T prev, T next) const noexcept {
    const Vec3<T> sum = to_prev + to_next * eta;
    const T length_squared = glm::dot(sum, sum);
    if (!(length_squared > T(0))) return {};
    const T side = prev > eta * next ? T(1) : T(-1);  // the facet's normal is on the side of `to_prev`
    const Vec3<T> half = sum * (side / std::sqrt(length_squared));
    const T facet_prev = glm::dot(half, to_prev);
    const T facet_next = -glm::dot(half, to_next);
    if (!(facet_prev > T(0) && facet_next > T(0))) return {};  // no facet does this
    // d(half)/d(to_next) = eta² · facet_next / |sum|²; the other way round without eta².
    const T distribution = ggx.distribution(half, normal) * facet_prev * facet_next / length_squared;
    const T lambda_prev = ggx.lambda(prev);
    const T lambda_next = ggx.lambda(next);
    const T eta2 = eta * eta;
    return {eta2 * distribution * ggx.visibility(lambda_prev, lambda_next) / (prev * next),
            eta2 * distribution * ggx.visibility(lambda_prev) / prev, distribution * ggx.visibility(lambda_next) / next,
            fresnel_dielectric(facet_prev, eta).reflectance};
  }

  [[nodiscard]] Vec3<T> sample_facet(const Vec3<T>& to_prev, const Vec2<T>& uv) const noexcept {
    const auto frame = Frame<T>::around(normal);
    return frame.to_world(ggx.sample_visible(frame.to_local(to_prev), uv));
  }
  [[nodiscard]] DielectricFresnel<T> fresnel_at(const Vec3<T>& to_prev, const Vec3<T>& half) const noexcept {
    return fresnel_dielectric(glm::dot(half, to_prev), eta);
  }
  /// The direction behind a facet; only where `fresnel_at` lets light through.
  [[nodiscard]] Vec3<T> refracted(const Vec3<T>& to_prev, const Vec3<T>& half, T cos_transmitted) const noexcept {
    return glm::normalize(half * (glm::dot(half, to_prev) / eta - cos_transmitted) - to_prev * (T(1) / eta));
  }
};

}  // namespace gmis::scene
