#pragma once

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <limits>
#include <memory>
#include <optional>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/scene/fresnel.hpp"
#include "gmis/scene/microfacet.hpp"

namespace gmis::scene {

/// How a surface scatters, made by the `make_…` functions below, which throw
/// `std::invalid_argument` for numbers out of range. All materials are two-sided: both sides
/// scatter alike, except that a dielectric has its inside behind the geometric normal. RGB, linear.
///
/// This is what a surface is at one point; `Material` adds what varies over the surface.
template <std::floating_point T = float>
struct PlainMaterial {
  /// How it scatters.
  enum class Kind {
    black,          ///< scatters nothing
    diffuse,        ///< Lambert
    phong,          ///< Lambert + modified Phong
    coated,         ///< Lambert under a rough coat
    smooth_coated,  ///< Lambert under a coat that is a delta mirror
    conductor,      ///< GGX with the Fresnel reflectance of a metal
    smooth_conductor,
    mirror,
    dielectric,               ///< a smooth interface
    rough_dielectric,         ///< GGX, reflecting and refracting
    diffuse_transmission,     ///< Lambert on both sides of a thin sheet
    coated_conductor,         ///< a GGX metal under a rough coat
    smooth_coated_conductor,  ///< a GGX metal under a coat that is a delta mirror
    coated_mirror,            ///< a smooth metal under a smooth coat
    mix                       ///< one of two materials at each point, see `make_mix`
  };
  using Rgb = Vec3<T>;

  Kind kind = Kind::black;                       ///< how it scatters
  bool is_varying = false;                       ///< it is a `Material` with textures
  bool is_thin = false;                          ///< of a smooth dielectric: a pane, both faces in one
  Masking masking = Masking::height_correlated;  ///< of rough lobes
  /// Chance of the diffuse lobe in `sample`, where there are two lobes.
  T diffuse_probability = 1;
  /// The weight of the reflecting one of the two lobes of a rough dielectric.
  T reflection_probability = 1;
  T exponent = 0;    ///< of Phong
  T alpha = 0;       ///< of GGX
  T eta = 1;         ///< of a dielectric or a coat, inside over outside
  Rgb diffuse{0};    ///< f of the diffuse lobe, reflectance / π; under a coat without the two transmittances
  Rgb specular{0};   ///< Phong: specular reflectance; mirror: reflectance; coat: scale of its Fresnel reflectance;
                     ///< diffuse transmission: f of the transmitting lobe, transmittance / π; dielectric: factor of
                     ///< refracted light
  Rgb metal_eta{1};  ///< index of a conductor …
  Rgb metal_k{0};    ///< … and its extinction
  Rgb albedo{0};     ///< about the share of light scattered on
  T base_alpha = 0;  ///< of GGX, of a metal under a coat
  T coat_reflectance = 0;  ///< of a coat over a Lambertian base, for diffuse light from outside
};

template <std::floating_point T>
struct MaterialTextures;

/// How much light media absorb on both sides of a surface: σ per scene unit and channel.
template <std::floating_point T>
struct Absorption {
  Vec3<T> inside{0};   ///< behind the geometric normal
  Vec3<T> outside{0};  ///< before it
};

/// How a surface scatters. `with_textures` and `make_mix` (varying_material.hpp) make one that
/// varies over the surface.
template <std::floating_point T = float>
struct Material : PlainMaterial<T> {
  std::shared_ptr<const MaterialTextures<T>> textures;  ///< null where nothing varies
  std::optional<Absorption<T>> absorption;              ///< of the boundary of a medium, see `with_absorption`
};

/// GGX with a smaller alpha is taken for a delta lobe.
inline constexpr double smallest_alpha = 1e-3;

namespace detail {

template <std::floating_point T>
inline Vec3<T> checked(const Vec3<T>& value, const char* what) {
  for (int c = 0; c < 3; ++c)
    if (!(value[c] >= T(0) && value[c] <= std::numeric_limits<T>::max())) reject_argument(what);
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

/// f = reflectance / π + specular (n + 2)/(2π) cosⁿ α, α the angle to the mirror direction; nothing
/// unless both directions are on the same side.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_phong(const glm::dvec3& reflectance, const glm::dvec3& specular,
                                            double exponent) {
  Material<T> result = make_diffuse<T>(reflectance);
  detail::checked(specular, "a specular reflectance must be finite and not negative");
  if (!(exponent >= 0 && exponent <= 1e6)) reject_argument("a Phong exponent must be from 0 to 1e6");
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

/// A metal of complex index eta + i k; `alpha` is that of GGX, below `smallest_alpha` a delta
/// mirror.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_conductor(const glm::dvec3& eta, const glm::dvec3& k, double alpha,
                                                Masking masking = Masking::height_correlated) {
  detail::checked(eta, "a metal's eta must be finite and not negative");
  detail::checked(k, "a metal's k must be finite and not negative");
  if (!(max_channel(eta) <= 1e6 && max_channel(k) <= 1e6)) reject_argument("a metal's eta and k must be at most 1e6");
  if (!(alpha >= 0 && alpha <= 1)) reject_argument("GGX alpha must be from 0 to 1");
  Material<T> result;
  result.kind = alpha < smallest_alpha ? Material<T>::Kind::smooth_conductor : Material<T>::Kind::conductor;
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  result.metal_eta = Vec3<T>(eta);
  result.metal_k = Vec3<T>(k);
  // Grazing light is reflected whole by any metal: a floor keeps Russian roulette from weights
  // above 10.
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

/// An interface; `eta` is the index behind the geometric normal over that before it. `alpha` is
/// that of GGX: the interface is smooth for an alpha below `smallest_alpha`, and for an index so
/// near 1 that light is bent by less than directions can tell (alpha |eta − 1| below 1e-4; with
/// eta = 1 roughness changes nothing). `tint`, from 0 to 1, is a factor of refracted light: that of
/// glass whose colour is in its surface.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_dielectric(double eta, double alpha = 0,
                                                 Masking masking = Masking::height_correlated,
                                                 const glm::dvec3& tint = glm::dvec3(1)) {
  if (!(eta > 0 && eta < 100)) reject_argument("an index of refraction must be above 0 and below 100");
  if (!(alpha >= 0 && alpha <= 1)) reject_argument("GGX alpha must be from 0 to 1");
  if (max_channel(detail::checked(tint, "a tint must be from 0 to 1")) > 1)
    reject_argument("a tint must be from 0 to 1");
  const bool is_rough = alpha >= smallest_alpha && alpha * std::abs(eta - 1) >= 1e-4;
  Material<T> result;
  result.kind = is_rough ? Material<T>::Kind::rough_dielectric : Material<T>::Kind::dielectric;
  result.eta = static_cast<T>(eta);
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  // The share of the reflecting lobe where each lobe is drawn from on its own: its mean reflectance
  // from outside, but enough for the light that total reflection holds back within.
  result.reflection_probability = static_cast<T>(std::clamp(fresnel_diffuse_reflectance(eta), 0.1, 0.9));
  result.specular = Vec3<T>(tint);
  result.albedo = Vec3<T>(1);
  return result;
}

/// A pane of smooth glass of index `eta`, both faces in one surface: light passes straight on, or
/// is reflected as by a mirror of reflectance 2R / (1 + R), with R that of one face; the light that
/// goes to and fro between the faces is in both. `tint`, from 0 to 1, is a factor of the light that
/// passes.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_thin_dielectric(double eta, const glm::dvec3& tint = glm::dvec3(1)) {
  Material<T> result = make_dielectric<T>(eta, 0, Masking::height_correlated, tint);
  result.is_thin = true;
  return result;
}

/// A Lambertian base of this reflectance under a dielectric coat of index `eta` and GGX `alpha`
/// (below `smallest_alpha` a delta lobe). Light that goes to and fro between base and coat is
/// summed as for a smooth coat: f = (1 − F(prev)) (1 − F(next)) · reflectance / (π η² (1 −
/// reflectance · F̄)) + scale · F D G / (4 cos cos), F̄ the diffuse reflectance of the coat from
/// within.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_coated_diffuse(const glm::dvec3& reflectance, double eta, double alpha,
                                                     const glm::dvec3& specular_scale,
                                                     Masking masking = Masking::height_correlated) {
  Material<T> result = make_diffuse<T>(reflectance);
  if (!(eta >= 1 && eta < 100)) reject_argument("a coat's index of refraction must be from 1 to 100");
  if (!(alpha >= 0 && alpha <= 1)) reject_argument("GGX alpha must be from 0 to 1");
  detail::checked(specular_scale, "a coat's specular scale must be from 0 to 1");
  if (!(max_channel(specular_scale) <= 1)) reject_argument("a coat's specular scale must be from 0 to 1");
  if (eta == 1 || max_channel(specular_scale) == 0) return result;
  const double from_outside = fresnel_diffuse_reflectance(eta);
  const double from_inside = 1 - (1 - from_outside) / (eta * eta);
  const glm::dvec3 base = reflectance / (eta * eta * (1.0 - reflectance * from_inside));
  result.kind = alpha < smallest_alpha ? Material<T>::Kind::smooth_coated : Material<T>::Kind::coated;
  result.eta = static_cast<T>(eta);
  result.alpha = static_cast<T>(alpha);
  result.masking = masking;
  result.specular = Vec3<T>(specular_scale);
  result.coat_reflectance = static_cast<T>(from_outside);
  result.diffuse = Vec3<T>(base / pi<double>);
  // Albedo under diffuse light: of the base (1 − F)² base, of the coat its mean Fresnel
  // reflectance.
  const glm::dvec3 diffuse_albedo = base * (1 - from_outside) * (1 - from_outside);
  const double glossy_albedo = max_channel(specular_scale) * from_outside;
  // Towards the horizon every coat reflects all there is, however little it reflects on the whole:
  // it gets a share that keeps weights below 10.
  result.diffuse_probability =
      static_cast<T>(std::min(max_channel(diffuse_albedo) / (max_channel(diffuse_albedo) + glossy_albedo), 0.9));
  result.albedo = Vec3<T>(glm::min(diffuse_albedo + glossy_albedo, glm::dvec3(1)));
  return result;
}

/// `make_coated_diffuse` with a grey specular scale.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_coated_diffuse(const glm::dvec3& reflectance, double eta, double alpha,
                                                     double specular_scale = 1,
                                                     Masking masking = Masking::height_correlated) {
  return make_coated_diffuse<T>(reflectance, eta, alpha, glm::dvec3(specular_scale), masking);
}

/// A thin sheet: f = reflectance / π between directions on one side, transmittance / π between the
/// two sides.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_diffuse_transmission(const glm::dvec3& reflectance,
                                                           const glm::dvec3& transmittance) {
  Material<T> result = make_diffuse<T>(reflectance);
  detail::checked(transmittance, "a diffuse transmittance must be finite and not negative");
  if (max_channel(transmittance) == 0) return result;
  result.kind = Material<T>::Kind::diffuse_transmission;
  result.specular = Vec3<T>(transmittance / pi<double>);
  result.albedo = Vec3<T>(reflectance + transmittance);
  result.diffuse_probability =
      static_cast<T>(max_channel(reflectance) / (max_channel(reflectance) + max_channel(transmittance)));
  return result;
}

/// A metal of index `eta` + i `k` and GGX `alpha` under a dielectric coat of index `coat_eta` and
/// GGX `coat_alpha`. Light that goes to and fro between coat and metal is summed as for two smooth
/// parallel layers, which is exact where both are smooth: with F of the coat and R of the metal
/// within it, F + (1 − F)² R / (1 − F R). A rough coat blurs the metal too: its α is then
/// √(alpha² + coat_alpha²). f = F D G / (4 cos cos) of the coat + F' D G / (4 cos cos) of the
/// metal, with F' = (1 − F(prev)) (1 − F(next)) R / (1 − F R), where F and R inside the fraction
/// are those at the facet.
template <std::floating_point T = float>
[[nodiscard]] inline Material<T> make_coated_conductor(const glm::dvec3& eta, const glm::dvec3& k, double alpha,
                                                       double coat_eta, double coat_alpha,
                                                       Masking masking = Masking::height_correlated) {
  if (!(coat_eta >= 1 && coat_eta < 100)) reject_argument("a coat's index of refraction must be from 1 to 100");
  if (!(coat_alpha >= 0 && coat_alpha <= 1)) reject_argument("GGX alpha must be from 0 to 1");
  Material<T> result = make_conductor<T>(eta, k, alpha, masking);
  if (coat_eta == 1) return result;
  using Kind = typename Material<T>::Kind;
  const bool is_rough_coat = coat_alpha >= smallest_alpha;
  const double base_alpha = is_rough_coat ? std::min(std::hypot(alpha, coat_alpha), 1.0) : alpha;
  result.kind = is_rough_coat                  ? Kind::coated_conductor
                : base_alpha >= smallest_alpha ? Kind::smooth_coated_conductor
                                               : Kind::coated_mirror;
  result.eta = static_cast<T>(coat_eta);
  result.alpha = static_cast<T>(coat_alpha);
  result.base_alpha = static_cast<T>(base_alpha);
  result.metal_eta = Vec3<T>(eta / coat_eta);
  result.metal_k = Vec3<T>(k / coat_eta);
  result.specular = Vec3<T>(1);
  const Vec3<T> metal = fresnel_conductor(T(1), result.metal_eta, result.metal_k);
  const T coat = static_cast<T>(fresnel_diffuse_reflectance(coat_eta));
  const T under = max_channel(metal) * square(T(1) - coat);
  result.diffuse_probability = std::clamp(under / (under + coat), T(0.1), T(0.9));
  result.albedo = glm::max(metal * square(T(1) - coat) + coat, Vec3<T>(T(0.1)));
  return result;
}

}  // namespace gmis::scene
