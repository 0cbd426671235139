#pragma once

#include <cmath>

#include "gmis/core/effects.hpp"
#include "gmis/scene/varying_material.hpp"

namespace gmis::scene {

/// True when the material scatters by non-delta lobes alone and has no diffuse part.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_purely_glossy(const PlainMaterial<T>& material) noexcept {
  using Kind = typename Material<T>::Kind;
  switch (material.kind) {
    case Kind::conductor:
    case Kind::rough_dielectric:
    case Kind::coated_conductor:
    case Kind::smooth_coated_conductor:
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
[[nodiscard]] constexpr bool has_narrow_lobe(const PlainMaterial<T>& material) noexcept {
  using Kind = typename Material<T>::Kind;
  constexpr T narrow = static_cast<T>(narrow_roughness);
  switch (material.kind) {
    case Kind::black:
    case Kind::diffuse:
    case Kind::diffuse_transmission:
      return false;
    case Kind::mix:  // a hit has one of its parts
    case Kind::mirror:
    case Kind::coated_mirror:
    case Kind::smooth_conductor:
    case Kind::dielectric:
    case Kind::smooth_coated:
    case Kind::smooth_coated_conductor:
      return true;
    case Kind::coated_conductor:
      return material.alpha < narrow || material.base_alpha < narrow;
    case Kind::phong:
      return T(2) < narrow * narrow * (material.exponent + T(2));
    case Kind::coated:
    case Kind::conductor:
    case Kind::rough_dielectric:
      return material.alpha < narrow;
  }
  return true;
}

/// Adds the effects that a surface of this material makes possible, without what its textures add.
template <std::floating_point T>
void add_plain_effects_of(const PlainMaterial<T>& material, Effects& effects) {
  using Kind = typename Material<T>::Kind;
  const bool has_diffuse = material.diffuse_probability > T(0) && !is_black(material.diffuse);
  switch (material.kind) {
    case Kind::black:
    case Kind::mix:
      return;
    case Kind::diffuse:
    case Kind::diffuse_transmission:
      effects.diffuse = true;
      return;
    case Kind::mirror:
    case Kind::smooth_conductor:
    case Kind::coated_mirror:
      effects.specular_reflection = true;
      return;
    case Kind::dielectric:
      effects.specular_reflection = effects.specular_transmission = true;
      return;
    case Kind::smooth_coated:
      effects.specular_reflection = true;
      effects.diffuse = effects.diffuse || has_diffuse;
      return;
    case Kind::smooth_coated_conductor:
      effects.specular_reflection = true;
      effects.add_glossy_lobe(static_cast<double>(material.base_alpha));
      break;
    case Kind::coated_conductor:
      effects.add_glossy_lobe(static_cast<double>(material.alpha));
      effects.add_glossy_lobe(static_cast<double>(material.base_alpha));
      break;
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

/// Adds the effects that a surface of this material makes possible.
template <std::floating_point T>
void add_effects_of(const Material<T>& material, Effects& effects) {
  add_plain_effects_of<T>(material, effects);
  if (!material.is_varying) return;
  const MaterialTextures<T>& textures = *material.textures;
  for (const Material<T>& part : textures.parts) add_effects_of(part, effects);
  if (textures.height || textures.normal_map) effects.shading_normals = true;
  if (!textures.roughness) return;
  PlainMaterial<T> roughest = material;
  const T roughness = std::clamp(textures.roughness->upper().x, T(0), T(1));
  roughest.alpha = std::max(material.alpha, textures.is_remapped ? std::sqrt(roughness) : roughness);
  add_plain_effects_of<T>(roughest, effects);
}

}  // namespace gmis::scene
