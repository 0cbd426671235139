#pragma once

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Reflection and refraction of unpolarised light at a smooth dielectric.
template <std::floating_point T>
struct DielectricFresnel {
  T reflectance;      ///< 1 under total internal reflection
  T cos_transmitted;  ///< cosine of the refracted direction, ≥ 0; 0 under total internal reflection
};

/// Exact Fresnel equations of a dielectric. `eta` is the index of refraction beyond the surface
/// divided by the index on the incident side; `cos_incident` ≥ 0. With `eta` = 1 nothing is
/// reflected at any angle.
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

/// Reflectance of a conductor of index eta + i k for unpolarised light from vacuum, with
/// `cos_incident` ≥ 0; exact Fresnel equations. From 0 to 1 whatever is rounded: both polarisations
/// are quotients of sums of squares,
/// |r_s|² = |c − w|² / |c + w|² and |r_p|² = |r_s|² |c w − s²|² / |c w + s²|², with c and s the cosine and sine of the angle
/// and w² = (eta + i k)² − s². With eta = 1 and k = 0 nothing is reflected at any angle.
template <std::floating_point T>
[[nodiscard]] inline T fresnel_conductor(T cos_incident, T eta, T k) noexcept {
  const T c = std::clamp(cos_incident, T(0), T(1));
  const T s2 = T(1) - c * c;
  const T real = (eta - T(1)) * (eta + T(1)) - k * k + c * c;  // of w², and its imaginary part
  const T imaginary = T(2) * eta * k;
  // The larger part of w comes from a sum, the smaller from their product: no digits are lost.
  const T modulus = std::max(std::sqrt(real * real + imaginary * imaginary), std::abs(real));  // squares may vanish
  const T larger = std::sqrt((modulus + std::abs(real)) / T(2));
  if (!(larger > T(0))) return eta == T(1) && k == T(0) ? T(0) : T(1);  // edge-on
  const T smaller = imaginary / (T(2) * larger);
  const T a = real >= T(0) ? larger : smaller, b = real >= T(0) ? smaller : larger;
  const T b2 = b * b;
  const T perpendicular = (square(c - a) + b2) / (square(c + a) + b2);
  const T through = square(c * b);
  const T parallel = perpendicular * ((square(c * a - s2) + through) / (square(c * a + s2) + through));
  return (parallel + perpendicular) / T(2);
}

/// Reflectance of a conductor per channel.
template <std::floating_point T>
[[nodiscard]] GMIS_NEVER_INLINE inline Vec3<T> fresnel_conductor(T cos_incident, const Vec3<T>& eta,
                                                                 const Vec3<T>& k) noexcept {
  return {fresnel_conductor(cos_incident, eta.x, k.x), fresnel_conductor(cos_incident, eta.y, k.y),
          fresnel_conductor(cos_incident, eta.z, k.z)};
}

/// The share of diffuse light that a smooth dielectric reflects: ∫ 2 F(cos θ) cos θ d(cos θ) over
/// [0, 1], by the midpoint rule.
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
