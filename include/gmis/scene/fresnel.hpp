#pragma once

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Reflection and refraction of unpolarised light at a smooth dielectric.
template <std::floating_point T>
struct DielectricFresnel {
  T reflectance;      ///< 1 under total internal reflection
  T cos_transmitted;  ///< cosine of the refracted direction, ≥ 0; 0 under total internal reflection
};

/// Exact Fresnel equations of a dielectric. `eta` is the index of refraction beyond the surface divided by the index on
/// the incident side; `cos_incident` ≥ 0. With `eta` = 1 nothing is reflected at any angle.
template <std::floating_point T>
[[nodiscard]] inline DielectricFresnel<T> fresnel_dielectric(T cos_incident, T eta) noexcept {
  if (eta == T(1)) return {T(0), cos_incident};
  const T cos_i = std::min(cos_incident, T(1));
  // eta² cos² θ_t = eta² − sin² θ_i, written without cancellation for an index near 1.
  const T scaled_cos2 = (eta - T(1)) * (eta + T(1)) + cos_i * cos_i;
  if (scaled_cos2 <= T(0)) return {T(1), T(0)};
  const T cos_t = std::min(std::sqrt(scaled_cos2) / eta, T(1));
  const T parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const T perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return {(parallel * parallel + perpendicular * perpendicular) / T(2), cos_t};
}

/// Reflectance of a conductor of index eta + i k for unpolarised light from vacuum, with `cos_incident` ≥ 0; exact
/// Fresnel equations.
template <std::floating_point T>
[[nodiscard]] inline T fresnel_conductor(T cos_incident, T eta, T k) noexcept {
  const T cos_i = std::clamp(cos_incident, T(0), T(1));
  const T cos2 = cos_i * cos_i;
  const T sin2 = T(1) - cos2;
  const T eta2 = eta * eta, k2 = k * k;
  const T t0 = eta2 - k2 - sin2;
  const T a2_plus_b2 = std::sqrt(t0 * t0 + T(4) * eta2 * k2);
  const T a = sqrt_or_zero((a2_plus_b2 + t0) / T(2));
  const T t1 = a2_plus_b2 + cos2;
  const T t2 = T(2) * cos_i * a;
  if (!(t1 + t2 > T(0))) return T(1);  // edge-on
  const T perpendicular = (t1 - t2) / (t1 + t2);
  const T t3 = cos2 * a2_plus_b2 + sin2 * sin2;
  const T t4 = t2 * sin2;
  const T parallel = t3 + t4 > T(0) ? perpendicular * (t3 - t4) / (t3 + t4) : T(1);
  return (parallel + perpendicular) / T(2);
}

/// Reflectance of a conductor per channel.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> fresnel_conductor(T cos_incident, const Vec3<T>& eta, const Vec3<T>& k) noexcept {
  return {fresnel_conductor(cos_incident, eta.x, k.x), fresnel_conductor(cos_incident, eta.y, k.y),
          fresnel_conductor(cos_incident, eta.z, k.z)};
}

/// The share of diffuse light that a smooth dielectric reflects: ∫ 2 F(cos θ) cos θ d(cos θ) over [0, 1], by the
/// midpoint rule.
[[nodiscard]] inline double fresnel_diffuse_reflectance(double eta) noexcept {
  constexpr int steps = 4096;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double cosine = (i + 0.5) / steps;
    sum += 2 * fresnel_dielectric(cosine, eta).reflectance * cosine;
  }
  return sum / steps;
}

}  // namespace gmis::scene
