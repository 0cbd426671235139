#pragma once

#include <concepts>

#include "gmis/core/concepts.hpp"
#include "gmis/core/effects.hpp"

namespace gmis::scene {

/// A BSDF that the built-in scene can give to its surfaces: `BvhScene<T, B>`, made by `SceneBuilder<T, B>`.
///
/// - `B::Material`: what a surface is made of; the scene keeps one for each `add_material`.
/// - `B(material, geometric_normal, shading_normal)`: the BSDF at a point, made at every hit; both normals are of unit
///   length and in one hemisphere. It may keep the address of the material, which stays valid as long as the scene does.
/// - `add_effects_of(material, effects)`: adds to `effects` what such a surface makes possible; a function in the
///   namespace of the material (found by argument-dependent lookup). What it leaves out may be left out of a rendering.
template <class B, class T>
concept SurfaceModel = Bsdf<B> && std::same_as<typename B::Spectrum, Vec3<T>> && requires {
  typename B::Material;
} && std::copyable<typename B::Material> && std::constructible_from < B, const typename B::Material&, const Vec3<T>
&, const Vec3<T>& > &&requires(const typename B::Material& material, Effects& effects) {
  {add_effects_of(material, effects)};
};

}  // namespace gmis::scene
