#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/scene/material.hpp"
#include "gmis/scene/surface_coordinates.hpp"
#include "gmis/scene/texture.hpp"

/// \file
/// Materials that vary over a surface. All that varies is a function of the surface point alone, so
/// subpaths from the camera and from the lights find the same surface.

namespace gmis::scene {

/// The textures of a material. Where a handle is null, the value of the plain material holds.
template <std::floating_point T>
struct MaterialTextures {
  using Handle = typename Texture<T>::Handle;
  Handle color;          ///< reflectance, cut to [0, 1]: of the diffuse lobe, a mirror, or a metal seen head on; the
                         ///< tint of a dielectric
  Handle transmittance;  ///< of diffuse transmission
  Handle roughness;      ///< its first channel, cut to [0, 1]
  bool is_remapped = false;  ///< α = √roughness instead of α = roughness
  Handle opacity;            ///< first channel: the share of the surface that is there, point by point
  Handle height;             ///< first channel: displacement along the shading normal in scene units, as a bump map
  Handle normal_map;  ///< (n + 1) / 2, n the normal in the frame of ∂p/∂u, its perpendicular, and the shading normal
  Handle amount;      ///< first channel: the share of the points that have the second of two `parts`
  std::vector<Material<T>> parts;  ///< of a mixture: two
};

/// `material` with these textures. Its own colour and roughness are replaced where there is a
/// texture for them. A texture of roughness needs a material that is rough. Throws
/// `std::invalid_argument` where the material has no such quantity.
template <std::floating_point T>
[[nodiscard]] inline Material<T> with_textures(const Material<T>& material, MaterialTextures<T> textures) {
  using Kind = typename Material<T>::Kind;
  const auto is_one_of = [&](std::initializer_list<Kind> kinds) {
    return std::find(kinds.begin(), kinds.end(), material.kind) != kinds.end();
  };
  if (textures.color &&
      !is_one_of({Kind::diffuse, Kind::phong, Kind::coated, Kind::smooth_coated, Kind::mirror, Kind::conductor,
                  Kind::smooth_conductor, Kind::diffuse_transmission, Kind::dielectric, Kind::rough_dielectric}))
    reject_argument("a material of this kind has no colour for a texture to replace");
  if (textures.transmittance && material.kind != Kind::diffuse_transmission)
    reject_argument("only diffuse transmission has a transmittance for a texture to replace");
  if (textures.roughness && !is_one_of({Kind::coated, Kind::conductor, Kind::rough_dielectric, Kind::coated_conductor}))
    reject_argument("a texture of roughness needs a material with a rough lobe");
  if (!textures.parts.empty() && (textures.parts.size() != 2 || !textures.amount))
    reject_argument("a mixture has two parts and an amount");
  const auto is_boundary = [](const Material<T>& part) { return part.absorption.has_value(); };
  if ((textures.opacity && is_boundary(material)) ||
      std::any_of(textures.parts.begin(), textures.parts.end(), is_boundary))
    reject_argument("the boundary of a medium cannot have holes, nor be a part of a mixture");
  Material<T> result = material;
  result.is_varying = true;
  if (textures.roughness) {
    // The smallest alpha of all points: a bound for the narrowest lobe.
    const T lowest = std::clamp(textures.roughness->lower().x, T(0), T(1));
    result.alpha = std::max(textures.is_remapped ? std::sqrt(lowest) : lowest, T(smallest_alpha));
  }
  if (material.textures) {  // both sets; the new one counts where both have something
    const MaterialTextures<T>& old = *material.textures;
    const auto keep = [](auto& now, const auto& before) { now = now ? now : before; };
    if (!textures.roughness) textures.is_remapped = old.is_remapped;
    keep(textures.color, old.color), keep(textures.transmittance, old.transmittance);
    keep(textures.roughness, old.roughness), keep(textures.opacity, old.opacity);
    keep(textures.height, old.height), keep(textures.normal_map, old.normal_map), keep(textures.amount, old.amount);
    if (textures.parts.empty()) textures.parts = old.parts;
  }
  result.textures = std::make_shared<const MaterialTextures<T>>(std::move(textures));
  return result;
}

/// Every point of the surface has one of the two materials: the second with the probability
/// `amount`, chosen by the position of the point. Over an area of many cells
/// (`SurfaceCoordinates::cell`) the surface scatters as the weighted mean of the two.
template <std::floating_point T>
[[nodiscard]] inline Material<T> make_mix(const Material<T>& first, const Material<T>& second,
                                          typename Texture<T>::Handle amount) {
  Material<T> result;
  result.kind = Material<T>::Kind::mix;
  MaterialTextures<T> textures;
  textures.amount = std::move(amount);
  textures.parts = {first, second};
  return with_textures(result, std::move(textures));
}

namespace detail {

/// A number in [0, 1) made of a position, the same for all positions in a cell around it; `salt`
/// tells independent choices apart.
template <std::floating_point T>
[[nodiscard]] inline T hashed(const SurfaceCoordinates<T>& at, std::uint64_t salt) noexcept {
  std::uint64_t bits = salt;
  for (int axis = 0; axis < 3; ++axis) {
    const T place = at.cell > T(0) ? std::round(at.position[axis] / at.cell) : at.position[axis];
    // + 0 so that −0 and 0 are one point.
    bits ^= std::bit_cast<std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>(place + T(0));
    // The finaliser of SplitMix64 [Steele et al. 2014].
    bits = (bits + 0x9E3779B97F4A7C15U);
    bits = (bits ^ (bits >> 30U)) * 0xBF58476D1CE4E5B9U;
    bits = (bits ^ (bits >> 27U)) * 0x94D049BB133111EBU;
    bits ^= bits >> 31U;
  }
  return static_cast<T>(bits >> 40U) * static_cast<T>(0x1p-24);
}

}  // namespace detail

/// The part of a mixture that this point has; the material itself where it is no mixture.
template <std::floating_point T>
[[nodiscard]] inline const Material<T>& part_at(const Material<T>& material, const SurfaceCoordinates<T>& at) noexcept {
  const Material<T>* part = &material;
  for (std::uint64_t depth = 1; part->kind == Material<T>::Kind::mix; ++depth) {
    const MaterialTextures<T>& textures = *part->textures;
    const bool is_second = detail::hashed(at, depth) < textures.amount->at(at.uv).x;
    part = &textures.parts[is_second ? 1 : 0];
  }
  return *part;
}

/// True when the surface may have holes.
template <std::floating_point T>
[[nodiscard]] inline bool has_opacity(const Material<T>& material) noexcept {
  return material.textures && material.textures->opacity;
}

/// True where there is no surface at this point: with the probability 1 − opacity, by its position.
template <std::floating_point T>
[[nodiscard]] inline bool is_cut_away(const Material<T>& material, const SurfaceCoordinates<T>& at) noexcept {
  if (!has_opacity(material)) return false;
  return !(detail::hashed(at, 0) < material.textures->opacity->at(at.uv).x);
}

/// The material at one point. `material` must vary and be no mixture.
template <std::floating_point T>
[[nodiscard]] inline PlainMaterial<T> resolved(const Material<T>& material, const Vec2<T>& uv) noexcept {
  using Kind = typename Material<T>::Kind;
  const MaterialTextures<T>& textures = *material.textures;
  PlainMaterial<T> here = material;
  here.is_varying = false;
  const auto color_of = [&](const auto& texture) { return glm::clamp(texture->at(uv), Vec3<T>(0), Vec3<T>(1)); };
  if (textures.roughness) {
    const T roughness = std::clamp(textures.roughness->at(uv).x, T(0), T(1));
    here.alpha = std::max(textures.is_remapped ? std::sqrt(roughness) : roughness, material.alpha);
  }
  if (textures.transmittance) here.specular = color_of(textures.transmittance) / pi<T>;
  const Vec3<T> color = textures.color ? color_of(textures.color) : Vec3<T>(0);
  // Each lobe keeps a share where the colour of the diffuse one varies.
  const auto share = [](T diffuse, T other) {
    return diffuse + other > T(0) ? std::clamp(diffuse / (diffuse + other), T(0.1), T(0.9)) : T(0.5);
  };
  switch (here.kind) {
    case Kind::diffuse:
      if (!textures.color) break;
      here.diffuse = color / pi<T>;
      here.albedo = color;
      break;
    case Kind::phong:
      if (!textures.color) break;
      here.diffuse = color / pi<T>;
      here.albedo = color + here.specular;
      here.diffuse_probability = share(max_channel(color), max_channel(here.specular));
      break;
    case Kind::coated:
    case Kind::smooth_coated: {
      if (!textures.color) break;
      const T eta2 = here.eta * here.eta;
      const T inside = T(1) - (T(1) - here.coat_reflectance) / eta2;
      const Vec3<T> base = color / (eta2 * (Vec3<T>(1) - color * inside));
      const Vec3<T> diffuse = base * square(T(1) - here.coat_reflectance);
      const T glossy = max_channel(here.specular) * here.coat_reflectance;
      here.diffuse = base / pi<T>;
      here.albedo = glm::min(diffuse + glossy, Vec3<T>(1));
      here.diffuse_probability = share(max_channel(diffuse), glossy);
      break;
    }
    case Kind::mirror:
      if (!textures.color) break;
      here.specular = here.albedo = color;
      break;
    case Kind::dielectric:
    case Kind::rough_dielectric:
      if (textures.color) here.specular = color;
      break;
    case Kind::conductor:
    case Kind::smooth_conductor: {
      if (!textures.color) break;
      const Vec3<T> r = glm::min(color, Vec3<T>(T(0.9999)));
      here.metal_eta = Vec3<T>(1);
      here.metal_k = T(2) * glm::sqrt(r) / glm::sqrt(Vec3<T>(1) - r);
      here.albedo = glm::max(r, Vec3<T>(T(0.1)));
      break;
    }
    case Kind::diffuse_transmission: {
      if (textures.color) here.diffuse = color / pi<T>;
      here.albedo = (here.diffuse + here.specular) * pi<T>;
      // A sheet of one lobe keeps it.
      if (textures.color || here.diffuse_probability > T(0))
        here.diffuse_probability = share(max_channel(here.diffuse), max_channel(here.specular));
      break;
    }
    default:
      break;
  }
  return here;
}

/// The shading normal under a bump or normal map: unit, and in the hemisphere of the geometric
/// normal, too, as `shading` is. Blinn's bump map: the normal of the surface p + height · shading
/// normal, where the normal itself changes slowly.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> perturbed_normal(const Material<T>& material, const SurfaceCoordinates<T>& at,
                                              const Vec3<T>& geometric, const Vec3<T>& shading) noexcept {
  const MaterialTextures<T>& textures = *material.textures;
  if (!textures.height && !textures.normal_map) return shading;
  const Vec3<T> along_u = at.along_u - shading * glm::dot(shading, at.along_u);
  const Vec3<T> along_v = at.along_v - shading * glm::dot(shading, at.along_v);
  const Vec3<T> facing = glm::cross(along_u, along_v);
  if (!(glm::dot(facing, facing) > T(0))) return shading;
  const T side = glm::dot(facing, shading) < T(0) ? T(-1) : T(1);
  Vec3<T> normal;
  if (textures.normal_map) {
    const Vec3<T> local = textures.normal_map->at(at.uv) * T(2) - T(1);
    const Vec3<T> tangent = glm::normalize(along_u);
    normal = tangent * local.x + glm::cross(shading, tangent) * (side * local.y) + shading * local.z;
  } else {
    constexpr T step = T(1) / T(2048);
    const auto height = [&](T u, T v) { return textures.height->at(at.uv + Vec2<T>(u, v)).x; };
    const T by_u = (height(step, 0) - height(-step, 0)) / (T(2) * step);
    const T by_v = (height(0, step) - height(0, -step)) / (T(2) * step);
    normal = glm::cross(along_u + shading * by_u, along_v + shading * by_v) * side;
  }
  const T length = glm::length(normal);
  if (!(length > T(0) && length < std::numeric_limits<T>::infinity())) return shading;
  normal /= length;
  // A normal that points inside is brought to just above the surface.
  constexpr T least = T(0.01);
  const T cosine = glm::dot(normal, geometric);
  return cosine >= least ? normal : glm::normalize(normal + geometric * (least - cosine));
}

}  // namespace gmis::scene
