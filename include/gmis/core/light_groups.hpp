#pragma once

#include <concepts>
#include <cstdint>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// A scene with the optional member `light_group(light)`: the number of the group that a light
/// belongs to, for a picture of each group (`RenderRequest::light_pictures`). A group is what its
/// user takes for one light: a mesh whose triangles are lights, all lamps of one kind. Numbers
/// begin at 0.
template <class S>
concept SceneWithLightGroups = Scene<S> && requires(const S& scene, const typename S::Light& light) {
  { scene.light_group(light) } -> std::same_as<std::uint16_t>;
};

/// `scene.light_group(light)`, or 0 for a scene without this member.
template <Scene Sc>
[[nodiscard]] constexpr std::uint16_t light_group_of([[maybe_unused]] const Sc& scene,
                                                     [[maybe_unused]] const typename Sc::Light& light) noexcept {
  if constexpr (SceneWithLightGroups<Sc>) {
    return scene.light_group(light);
  } else {
    static_assert(
        !requires(Sc & any) { any.light_group(light); }, "light_group(light) const must return std::uint16_t");
    return 0;
  }
}

}  // namespace gmis
