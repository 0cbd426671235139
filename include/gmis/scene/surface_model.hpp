#pragma once

#include <concepts>

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/scene/surface_coordinates.hpp"

namespace gmis::scene {

/// A BSDF that the built-in scene can give to its surfaces: `BvhScene<T, B>`, made by
/// `SceneBuilder<T, B>`.
///
/// - `B::Material`: what a surface is made of; the scene keeps one for each `add_material`.
/// - `B(material, geometric_normal, shading_normal)`: the BSDF at a point, made at every hit; both
///   normals are of unit length and in one hemisphere. It may keep the address of the material,
///   which stays valid as long as the scene does.
/// - `add_effects_of(material, effects)`: adds to `effects` what such a surface makes possible; a
///   function in the namespace of the material (found by argument-dependent lookup). What it leaves
///   out may be left out of a rendering.
template <class B, class T>
concept SurfaceModel = Bsdf<B> && std::same_as<typename B::Spectrum, Vec3<T>> && requires {
  typename B::Material;
} && std::copyable<typename B::Material> && std::constructible_from < B, const typename B::Material&, const Vec3<T>
&, const Vec3<T>& > &&requires(const typename B::Material& material, Effects& effects) {
  {add_effects_of(material, effects)};
};

/// \cond
// Never defined; core/missing_members.hpp says what these are for.
// clang-format off
namespace surface_model_lacks {
template <class B, class T>
struct Spectrum;  // using Spectrum = gmis::Vec3<T>
template <class B>
struct Material;  // using Material = …, a type that can be copied
template <class B, class T>
struct constructor;  // B(const Material&, Vec3<T> geometric_normal, Vec3<T> shading_normal)
template <class Material>
struct add_effects_of;  // void add_effects_of(const Material&, gmis::Effects&), beside Material
}  // namespace surface_model_lacks
// clang-format on

namespace detail {
template <class B, class T>
consteval auto surface_model_verdict() {
  if constexpr (SurfaceModel<B, T>) {
    return std::type_identity<std::true_type>();
  } else if constexpr (!Bsdf<B>) {
    return gmis::detail::bsdf_verdict<B>();
  } else if constexpr (!std::same_as<typename B::Spectrum, Vec3<T>>) {
    return std::type_identity<surface_model_lacks::Spectrum<B, T>>();
  } else if constexpr (!requires {
                         typename B::Material;
                         requires std::copyable<typename B::Material>;
                       }) {
    return std::type_identity<surface_model_lacks::Material<B>>();
  } else if constexpr (!std::constructible_from<B, const typename B::Material&, const Vec3<T>&, const Vec3<T>&>) {
    return std::type_identity<surface_model_lacks::constructor<B, T>>();
  } else {
    return std::type_identity<surface_model_lacks::add_effects_of<typename B::Material>>();
  }
}
}  // namespace detail
/// \endcond

/// `IsSurfaceModel<B, T>()` is true where `SurfaceModel<B, T>` holds; else the compiler's first
/// line names what is missing.
template <class B, class T>
using IsSurfaceModel = typename decltype(detail::surface_model_verdict<B, T>())::type;

/// A surface model whose materials may vary over the surface.
///
/// - `material.is_varying`: this material does, at least somewhere.
/// - `B(material, geometric_normal, shading_normal, coordinates)`: the BSDF at this point of such a
///   surface, made instead of the one above. `shading_normal()` is then the normal that it uses, of
///   unit length and in the hemisphere of the geometric normal.
/// - `has_opacity(material)` and `is_cut_away(material, coordinates)`: whether there may be points
///   without a surface, and whether this is one; functions of the surface point alone.
template <class B, class T>
concept VaryingSurfaceModel = SurfaceModel<B, T> &&
    requires(const typename B::Material& material, const Vec3<T>& normal, const SurfaceCoordinates<T>& at, const B& b) {
  { material.is_varying } -> std::convertible_to<bool>;
  {B(material, normal, normal, at)};
  { b.shading_normal() } -> std::convertible_to<Vec3<T>>;
  { has_opacity(material) } -> std::same_as<bool>;
  { is_cut_away(material, at) } -> std::same_as<bool>;
};

}  // namespace gmis::scene
