#pragma once

#include <algorithm>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// GGX roughness α below which a lobe counts as narrow: a sample of a light or of another subpath
/// seldom falls into it. For a lobe like cosⁿ it is an exponent above 30.
inline constexpr double narrow_roughness = 0.25;

/// The properties of a scene that determine which kinds of paths it has. A technique that a missing
/// property makes useless may be left out. A property that is set without need costs time; a
/// property that is wrongly missing loses light.
///
/// Roughness is α of GGX, or an approximation of it: √(2 / (n + 2)) for a lobe like cosⁿ.
struct Effects {
  // Surfaces, except black ones.
  bool diffuse = false;                ///< some surface scatters with a diffuse part, or in an unknown way
  bool glossy = false;                 ///< some surface has a non-delta lobe that is narrower than diffuse
  bool purely_glossy = false;          ///< some surface has non-delta lobes but no diffuse part
  double least_roughness = 1;          ///< smallest roughness of all glossy lobes
  double greatest_roughness = 0;       ///< largest roughness of all glossy lobes
  bool specular_reflection = false;    ///< some surface has a delta lobe of reflection
  bool specular_transmission = false;  ///< some surface has a delta lobe of transmission
  bool shading_normals = false;        ///< shading and geometric normals differ somewhere

  // Lights, except black ones.
  bool area_lights = false;         ///< surfaces that emit
  bool point_lights = false;        ///< lights at one point
  bool spot_lights = false;         ///< point lights within a cone
  bool directional_lights = false;  ///< lights from one direction
  bool environment_lights = false;  ///< light from all directions, from infinitely far

  bool thin_lens = false;  ///< the camera has a lens, so that it blurs

  /// Some surface has a delta lobe.
  [[nodiscard]] constexpr bool has_specular() const noexcept { return specular_reflection || specular_transmission; }
  /// True when some surface has a lobe that is delta or narrower than `narrow_roughness`.
  [[nodiscard]] constexpr bool has_narrow_lobes() const noexcept {
    return has_specular() || (glossy && least_roughness < narrow_roughness);
  }
  /// True when some surface scatters by a non-delta lobe: connections, merging and next events can
  /// work there.
  [[nodiscard]] constexpr bool has_scattering() const noexcept { return diffuse || glossy || purely_glossy; }
  /// True when the scene has a light that a ray can hit.
  [[nodiscard]] constexpr bool has_extended_lights() const noexcept { return area_lights || environment_lights; }
  /// True when the scene has a light that no ray can hit.
  [[nodiscard]] constexpr bool has_delta_lights() const noexcept {
    return point_lights || spot_lights || directional_lights;
  }
  /// Something emits.
  [[nodiscard]] constexpr bool has_lights() const noexcept { return has_extended_lights() || has_delta_lights(); }

  /// Adds a non-delta lobe of this roughness that is narrower than diffuse.
  constexpr void add_glossy_lobe(double roughness) noexcept {
    glossy = true;
    least_roughness = std::min(least_roughness, roughness);
    greatest_roughness = std::max(greatest_roughness, roughness);
  }

  /// All properties set, with lobes of any roughness: the default for a scene that does not report
  /// its effects.
  [[nodiscard]] static constexpr Effects everything() noexcept {
    return {true, true, true, 0, 1, true, true, true, true, true, true, true, true, true};
  }

  friend constexpr bool operator==(const Effects&, const Effects&) = default;
};

/// A scene with the optional member `effects()`.
template <class S>
concept SceneWithEffects = Scene<S> && requires(const S& scene) {
  { scene.effects() } -> std::convertible_to<Effects>;
};

/// `scene.effects()`, or `Effects::everything()` for a scene without this member.
template <Scene S>
[[nodiscard]] inline Effects effects_of(const S& scene) {
  if constexpr (SceneWithEffects<S>)
    return scene.effects();
  else
    return Effects::everything();
}

}  // namespace gmis
