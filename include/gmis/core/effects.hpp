#pragma once

#include <algorithm>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// What a scene has that makes paths of different kinds: what may occur, so that whatever is not named here need not be
/// looked for. To say too much costs time, to say too little loses light.
///
/// Roughness is that of GGX, or what comes near it: √(2 / (n + 2)) for a lobe like cosⁿ.
struct Effects {
  // Surfaces. One that scatters nothing counts for nothing.
  bool diffuse = false;                ///< a surface scatters with a diffuse part (or nobody knows how it scatters)
  bool glossy = false;                 ///< a surface has a lobe narrower than diffuse that is no delta lobe …
  bool purely_glossy = false;          ///< … and one has such lobes and no diffuse part
  double least_roughness = 1;          ///< of all glossy lobes
  double greatest_roughness = 0;       ///< of all glossy lobes
  bool specular_reflection = false;    ///< a delta lobe on the side where the light comes from
  bool specular_transmission = false;  ///< a delta lobe on the other side
  bool shading_normals = false;        ///< they differ from the geometric ones somewhere

  // Lights that are not black.
  bool area_lights = false;
  bool point_lights = false;
  bool spot_lights = false;
  bool directional_lights = false;
  bool environment_lights = false;

  bool thin_lens = false;

  [[nodiscard]] constexpr bool has_specular() const noexcept { return specular_reflection || specular_transmission; }
  /// Some surface can be connected, merged and sampled a light for.
  [[nodiscard]] constexpr bool has_scattering() const noexcept { return diffuse || glossy || purely_glossy; }
  /// Lights that a ray can meet, and lights that none can.
  [[nodiscard]] constexpr bool has_extended_lights() const noexcept { return area_lights || environment_lights; }
  [[nodiscard]] constexpr bool has_delta_lights() const noexcept {
    return point_lights || spot_lights || directional_lights;
  }
  [[nodiscard]] constexpr bool has_lights() const noexcept { return has_extended_lights() || has_delta_lights(); }

  constexpr void add_glossy_lobe(double roughness) noexcept {
    glossy = true;
    least_roughness = std::min(least_roughness, roughness);
    greatest_roughness = std::max(greatest_roughness, roughness);
  }

  /// For a scene that does not say: all of it may occur, lobes of any roughness.
  [[nodiscard]] static constexpr Effects everything() noexcept {
    return {true, true, true, 0, 1, true, true, true, true, true, true, true, true, true};
  }

  friend constexpr bool operator==(const Effects&, const Effects&) = default;
};

/// A scene that says what it has.
template <class S>
concept SceneWithEffects = Scene<S> && requires(const S& scene) {
  { scene.effects() } -> std::convertible_to<Effects>;
};

/// What the scene says of itself, or that everything may occur.
template <Scene S>
[[nodiscard]] inline Effects effects_of(const S& scene) {
  if constexpr (SceneWithEffects<S>)
    return scene.effects();
  else
    return Effects::everything();
}

}  // namespace gmis
