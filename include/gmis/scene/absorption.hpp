#pragma once

#include <concepts>
#include <optional>

#include "gmis/core/argument_error.hpp"
#include "gmis/scene/varying_material.hpp"

/// \file
/// Glass that absorbs light on its way through, by the law of Beer and Lambert: exp(−σ · distance),
/// per channel. Which segments are inside is read off the surfaces alone: a segment is in the
/// medium that the next boundary along its ray has on this side. So the shapes of such materials
/// must be closed.

namespace gmis::scene {

/// `material`, a dielectric, as the boundary of media that absorb: `inside` is σ behind the
/// geometric normal, `outside` σ before it, per scene unit and channel. A boundary between two
/// media, as of water in a glass, has both; the outside of the outermost boundary must be clear.
/// Throws `std::invalid_argument` for another material, for one with holes, and for numbers that
/// are negative or not finite.
template <std::floating_point T>
[[nodiscard]] inline Material<T> with_absorption(const Material<T>& material, const glm::dvec3& inside,
                                                 const glm::dvec3& outside = glm::dvec3(0)) {
  if ((material.kind != Material<T>::Kind::dielectric && material.kind != Material<T>::Kind::rough_dielectric) ||
      material.is_thin)
    reject_argument("only a dielectric can be the boundary of a medium that absorbs");
  if (has_opacity(material)) reject_argument("the boundary of a medium cannot have holes");
  Material<T> result = material;
  result.absorption = Absorption<T>{Vec3<T>(detail::checked(inside, "an absorption must be finite and not negative")),
                                    Vec3<T>(detail::checked(outside, "an absorption must be finite and not negative"))};
  return result;
}

/// The absorption on both sides; null for a surface that is no boundary.
template <std::floating_point T>
[[nodiscard]] inline const Absorption<T>* absorption_of(const Material<T>& material) noexcept {
  return material.absorption ? &*material.absorption : nullptr;
}

namespace detail {

template <class M, class T>
concept MaterialWithAbsorption = requires(const M& material) {
  { absorption_of(material) } -> std::same_as<const Absorption<T>*>;
};

}  // namespace detail

/// The absorption of a built-in scene's material of any type; null where it has none.
template <std::floating_point T, class M>
[[nodiscard]] inline const Absorption<T>* boundary_of(const M& material) noexcept {
  if constexpr (detail::MaterialWithAbsorption<M, T>)
    return absorption_of(material);
  else if constexpr (requires { material.first(), material.second(); })
    return material.first() ? boundary_of<T>(*material.first()) : boundary_of<T>(*material.second());
  else
    return nullptr;
}

}  // namespace gmis::scene
