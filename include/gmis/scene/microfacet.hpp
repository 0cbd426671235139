#pragma once

#include <limits>

#include "gmis/core/warp.hpp"

namespace gmis::scene {

/// The joint masking and shadowing of the two directions of a microfacet lobe, from Smith's Λ of
/// each.
enum class Masking {
  height_correlated,  ///< 1/(1 + Λ(prev) + Λ(next)) [Heitz 2014]
  separable           ///< G1(prev) · G1(next)
};

/// The isotropic GGX distribution of half vectors, with its axis along +z.
template <std::floating_point T>
struct Ggx {
  T alpha;                                       ///< roughness, above 0
  Masking masking = Masking::height_correlated;  ///< whether both directions are masked together

  /// D(h) per steradian, for a half vector with this cosine to the axis.
  [[nodiscard]] T distribution(T cos_half) const noexcept {
    const T a2 = alpha * alpha;
    // cos²(a² − 1) + 1, written without cancellation near the peak.
    const T cos2 = std::min(cos_half * cos_half, T(1));
    const T d = cos2 * a2 + (T(1) - cos2);
    return a2 / (pi<T> * d * d);
  }

  /// D(h) per steradian, for a unit half vector and a unit axis. It stays accurate on a nearly
  /// smooth surface, where the cosine rounds to 1.
  [[nodiscard]] T distribution(const Vec3<T>& half, const Vec3<T>& axis) const noexcept {
    const Vec3<T> across = glm::cross(half, axis);
    const T a2 = alpha * alpha;
    const T d = a2 + std::min(glm::dot(across, across), T(1)) * (T(1) - a2);
    return a2 / (pi<T> * d * d);
  }

  /// Smith's Λ of a direction with this cosine > 0 to the axis.
  [[nodiscard]] T lambda(T cosine) const noexcept {
    const T cos2 = std::max(cosine * cosine, std::numeric_limits<T>::min());
    const T tan2 = std::max(T(0), T(1) - cos2) / cos2;
    return (std::sqrt(T(1) + alpha * alpha * tan2) - T(1)) / T(2);
  }
  /// Masking G1 = 1/(1 + Λ) of one direction.
  [[nodiscard]] T visibility(T lambda_of_one) const noexcept { return T(1) / (T(1) + lambda_of_one); }
  /// Joint masking and shadowing G2 of two directions with these Λ.
  [[nodiscard]] T visibility(T lambda_prev, T lambda_next) const noexcept {
    return masking == Masking::height_correlated ? T(1) / (T(1) + lambda_prev + lambda_next)
                                                 : visibility(lambda_prev) * visibility(lambda_next);
  }

  /// A half vector that is visible from `prev` (local frame, prev.z > 0). Its density is D(h)
  /// G1(prev) max(0, prev · h) / prev.z per steradian [Heitz 2018].
  [[nodiscard]] Vec3<T> sample_visible(const Vec3<T>& prev, const Vec2<T>& uv) const noexcept {
    const Vec3<T> stretched = glm::normalize(Vec3<T>(alpha * prev.x, alpha * prev.y, prev.z));
    const Frame<T> frame = Frame<T>::around(stretched);
    // A point on the projection of the half sphere, seen from `stretched`. The part below the
    // horizon is compressed.
    const T radius = std::sqrt(uv.x);
    const auto [cosine, sine] = cos_sin_of_turns(uv.y);
    // The first axis of the frame must be horizontal.
    const T horizontal2 = stretched.x * stretched.x + stretched.y * stretched.y;
    Vec3<T> across = frame.tangent;
    Vec3<T> along = frame.bitangent;
    if (horizontal2 > T(0)) {
      const T scale = T(1) / std::sqrt(horizontal2);
      across = {-stretched.y * scale, stretched.x * scale, T(0)};
      along = glm::cross(stretched, across);
    }
    const T x = radius * cosine;
    T y = radius * sine;
    const T blend = (T(1) + stretched.z) / T(2);
    y = (T(1) - blend) * sqrt_or_zero(T(1) - x * x) + blend * y;
    const T z = sqrt_or_zero(T(1) - x * x - y * y);
    const Vec3<T> half = across * x + along * y + stretched * z;
    return glm::normalize(Vec3<T>(alpha * half.x, alpha * half.y, std::max(half.z, T(1e-7))));
  }
};

}  // namespace gmis::scene
