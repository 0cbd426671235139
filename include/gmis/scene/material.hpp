#pragma once

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <limits>
#include <stdexcept>

#include "gmis/core/spectrum.hpp"
#include "gmis/scene/fresnel.hpp"
#include "gmis/scene/microfacet.hpp"

namespace gmis::scene {

/// How a surface scatters, made by the `make_…` functions below. All materials are two-sided: the side that a
/// direction is on counts, not which of the two it is, except that a dielectric has its inside behind the geometric
/// normal. RGB, linear.
template <std::floating_point T = float>
struct Material {
  enum class Kind {
    black,          ///< scatters nothing
    diffuse,        ///< Lambert
    phong,          ///< Lambert + modified Phong
    coated,         ///< Lambert under a rough coat
    smooth_coated,  ///< Lambert under a coat that is a delta mirror
    conductor,      ///< GGX with the Fresnel reflectance of a metal
    smooth_conductor,
    mirror,
    dielectric,       ///< a smooth interface
    rough_dielectric  ///< GGX, reflecting and refracting
  };
  using Rgb = Vec3<T>;

  Kind kind = Kind::black;
  Masking masking = Masking::height_correlated;
  /// Chance of the diffuse lobe in `sample`, where there are two lobes.
  T diffuse_probability = 1;
  /// The weight of the reflecting one of the two lobes of a rough dielectric.
  T reflection_probability = 1;
  T exponent = 0;    ///< of Phong
  T alpha = 0;       ///< of GGX
  T eta = 1;         ///< of a dielectric or a coat, inside over outside
  Rgb diffuse{0};    ///< f of the diffuse lobe, reflectance / π; under a coat without the two transmittances
  Rgb specular{0};   ///< Phong: specular reflectance; mirror: reflectance; coat: scale of its Fresnel reflectance
  Rgb metal_eta{1};  ///< index of a conductor …
  Rgb metal_k{0};    ///< … and its extinction
  Rgb albedo{0};     ///< about the share of light scattered on
};

/// GGX with a smaller alpha is taken for a delta lobe.
inline constexpr double smallest_alpha = 1e-3;

namespace detail {

template <std::floating_point T>
inline Vec3<T> checked(const Vec3<T>& value, const char* what) {
  for (int c = 0; c < 3; ++c)
    if (!(value[c] >= T(0) && value[c] <= std::numeric_limits<T>::max())) throw std::invalid_argument(what);
  return value;
}

}  // namespace detail

/// f = reflectance / π.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_diffuse(const glm::dvec3& reflectance) {
  Material<T> result;
  result.albedo = Vec3<T>(detail::checked(reflectance, "a diffuse reflectance must be finite and not negative"));
  result.diffuse = Vec3<T>(reflectance / pi<double>);
  result.kind = is_black(result.albedo) ? Material<T>::Kind::black : Material<T>::Kind::diffuse;
  return result;
}

/// f = reflectance / π + specular (n + 2)/(2π) cosⁿ α, α the angle to the mirror direction; nothing unless both
/// directions are on the same side.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_phong(const glm::dvec3& reflectance, const glm::dvec3& specular,
                                            double exponent) {
  Material<T> result = make_diffuse<T>(reflectance);
  detail::checked(specular, "a specular reflectance must be finite and not negative");
  if (!(exponent >= 0 && exponent <= 1e6)) throw std::invalid_argument("a Phong exponent must be from 0 to 1e6");
  const double glossy = max_channel(specular);
  if (glossy == 0) return result;
  result.kind = Material<T>::Kind::phong;
  result.exponent = static_cast<T>(exponent);
  result.specular = Vec3<T>(specular);
  result.diffuse_probability = static_cast<T>(max_channel(reflectance) / (max_channel(reflectance) + glossy));
  result.albedo = Vec3<T>(reflectance + specular);
  return result;
}

/// A delta reflection with a constant reflectance.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_mirror(const glm::dvec3& reflectance) {
  Material<T> result;
  result.specular = Vec3<T>(detail::checked(reflectance, "a mirror's reflectance must be finite and not negative"));
  result.albedo = result.specular;
  result.kind = is_black(result.albedo) ? Material<T>::Kind::black : Material<T>::Kind::mirror;
  return result;
}

/// A metal of complex index eta + i k; `alpha` is that of GGX, below `smallest_alpha` a delta mirror.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_conductor(const glm::dvec3& eta, const glm::dvec3& k, double alpha,
                                                Masking masking = Masking::height_correlated) {
  detail::checked(eta, "a metal's eta must be finite and not negative");
  detail::checked(k, "a metal's k must be finite and not negative");
  if (!(alpha >= 0 && alpha <= 1)) throw std::invalid_argument("GGX alpha must be from 0 to 1");
  Material<T> result;
  result.kind = alpha < smallest_alpha ? Material<T>::Kind::smooth_conductor : Material<T>::Kind::conductor;
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  result.metal_eta = Vec3<T>(eta);
  result.metal_k = Vec3<T>(k);
  // Grazing light is reflected whole by any metal: a floor keeps Russian roulette from weights above 10.
  result.albedo = glm::max(fresnel_conductor(T(1), result.metal_eta, result.metal_k), Vec3<T>(T(0.1)));
  return result;
}

/// A metal given by the reflectance that it has head on, as eta = 1 and the k that makes it.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_conductor_of_reflectance(const glm::dvec3& reflectance, double alpha,
                                                               Masking masking = Masking::height_correlated) {
  const glm::dvec3 r =
      glm::min(detail::checked(reflectance, "a reflectance must be finite and not negative"), glm::dvec3(0.9999));
  return make_conductor<T>(glm::dvec3(1), 2.0 * glm::sqrt(r) / glm::sqrt(1.0 - r), alpha, masking);
}

/// An interface; `eta` is the index behind the geometric normal over that before it. `alpha` is that of GGX: a smooth
/// interface is what comes of an alpha below `smallest_alpha`, and of an index so near 1 that light is bent by less than
/// directions can tell (alpha · |eta − 1| below 1e-4; with eta = 1 roughness changes nothing).
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_dielectric(double eta, double alpha = 0,
                                                 Masking masking = Masking::height_correlated) {
  if (!(eta > 0 && eta < 100)) throw std::invalid_argument("an index of refraction must be above 0 and below 100");
  if (!(alpha >= 0 && alpha <= 1)) throw std::invalid_argument("GGX alpha must be from 0 to 1");
  const bool is_rough = alpha >= smallest_alpha && alpha * std::abs(eta - 1) >= 1e-4;
  Material<T> result;
  result.kind = is_rough ? Material<T>::Kind::rough_dielectric : Material<T>::Kind::dielectric;
  result.eta = static_cast<T>(eta);
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  // The share of the reflecting lobe where each lobe is drawn from on its own: its mean reflectance from outside, but
  // enough for the light that total reflection holds back within.
  result.reflection_probability = static_cast<T>(std::clamp(fresnel_diffuse_reflectance(eta), 0.1, 0.9));
  result.albedo = Vec3<T>(1);
  return result;
}

/// A Lambertian base of this reflectance under a dielectric coat of index `eta` and GGX `alpha` (below `smallest_alpha`
/// a delta lobe). Light that goes to and fro between base and coat is summed as for a smooth coat:
/// f = (1 − F(prev)) (1 − F(next)) · reflectance / (π η² (1 − reflectance · F̄)) + scale · F D G / (4 cos cos),
/// F̄ the diffuse reflectance of the coat from within.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_coated_diffuse(const glm::dvec3& reflectance, double eta, double alpha,
                                                     double specular_scale = 1,
                                                     Masking masking = Masking::height_correlated) {
  Material<T> result = make_diffuse<T>(reflectance);
  if (!(eta >= 1 && eta < 100)) throw std::invalid_argument("a coat's index of refraction must be from 1 to 100");
  if (!(alpha >= 0 && alpha <= 1)) throw std::invalid_argument("GGX alpha must be from 0 to 1");
  if (!(specular_scale >= 0 && specular_scale <= 1))
    throw std::invalid_argument("a coat's specular scale must be from 0 to 1");
  if (eta == 1 || specular_scale == 0) return result;
  const double from_outside = fresnel_diffuse_reflectance(eta);
  const double from_inside = 1 - (1 - from_outside) / (eta * eta);
  const glm::dvec3 base = reflectance / (eta * eta * (1.0 - reflectance * from_inside));
  result.kind = alpha < smallest_alpha ? Material<T>::Kind::smooth_coated : Material<T>::Kind::coated;
  result.eta = static_cast<T>(eta);
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  result.specular = Vec3<T>(static_cast<T>(specular_scale));
  result.diffuse = Vec3<T>(base / pi<double>);
  // Albedo under diffuse light: of the base (1 − F)² base, of the coat its mean Fresnel reflectance.
  const glm::dvec3 diffuse_albedo = base * (1 - from_outside) * (1 - from_outside);
  const double glossy_albedo = specular_scale * from_outside;
  // Towards the horizon every coat reflects all there is, however little it reflects on the whole: it gets a share that
  // keeps weights below 10.
  result.diffuse_probability =
      static_cast<T>(std::min(max_channel(diffuse_albedo) / (max_channel(diffuse_albedo) + glossy_albedo), 0.9));
  result.albedo = Vec3<T>(glm::min(diffuse_albedo + glossy_albedo, glm::dvec3(1)));
  return result;
}

}  // namespace gmis::scene
