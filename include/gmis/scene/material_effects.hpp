#pragma once

#include <cmath>

#include "gmis/core/effects.hpp"
#include "gmis/scene/material.hpp"

namespace gmis::scene {

/// True when the material scatters by non-delta lobes alone and has no diffuse part.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_purely_glossy(const Material<T>& material) noexcept {
  using Kind = typename Material<T>::Kind;
  switch (material.kind) {
    case Kind::conductor:
    case Kind::rough_dielectric:
      return true;
    case Kind::phong:
    case Kind::coated:
      return !(material.diffuse_probability > T(0));
    default:
      return false;
  }
}

/// True when the material has a lobe that is delta or narrower than `narrow_roughness`.
template <std::floating_point T>
[[nodiscard]] constexpr bool has_narrow_lobe(const Material<T>& material) noexcept {
  using Kind = typename Material<T>::Kind;
  constexpr T narrow = static_cast<T>(narrow_roughness);
  switch (material.kind) {
    case Kind::black:
    case Kind::diffuse:
      return false;
    case Kind::mirror:
    case Kind::smooth_conductor:
    case Kind::dielectric:
    case Kind::smooth_coated:
      return true;
    case Kind::phong:
      return T(2) < narrow * narrow * (material.exponent + T(2));
    case Kind::coated:
    case Kind::conductor:
    case Kind::rough_dielectric:
      return material.alpha < narrow;
  }
  return true;
}

/// Adds the effects that a surface of this material makes possible.
template <std::floating_point T>
void add_effects_of(const Material<T>& material, Effects& effects) {
  using Kind = typename Material<T>::Kind;
  const bool has_diffuse = material.diffuse_probability > T(0) && !is_black(material.diffuse);
  switch (material.kind) {
    case Kind::black:
      return;
    case Kind::diffuse:
      effects.diffuse = true;
      return;
    case Kind::mirror:
    case Kind::smooth_conductor:
      effects.specular_reflection = true;
      return;
    case Kind::dielectric:
      effects.specular_reflection = effects.specular_transmission = true;
      return;
    case Kind::smooth_coated:
      effects.specular_reflection = true;
      effects.diffuse = effects.diffuse || has_diffuse;
      return;
    case Kind::phong:
      effects.add_glossy_lobe(std::sqrt(2 / (static_cast<double>(material.exponent) + 2)));
      break;
    case Kind::coated:
    case Kind::conductor:
    case Kind::rough_dielectric:
      effects.add_glossy_lobe(static_cast<double>(material.alpha));
      break;
  }
  if (is_purely_glossy(material))
    effects.purely_glossy = true;
  else
    effects.diffuse = true;
}

}  // namespace gmis::scene
