#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gmis/transport/state/path_class.hpp"

namespace gmis {

/// The ways to make a path from a camera subpath, a light subpath or both.
enum class Technique : std::uint8_t { emitter_hit, next_event, connect, splat, merge };
inline constexpr std::size_t technique_count = 5;
inline constexpr std::array<Technique, technique_count> all_techniques{
    Technique::emitter_hit, Technique::next_event, Technique::connect, Technique::splat, Technique::merge};

/// The technique that made a path of `s` light and `t` camera vertices. A merged vertex counts on
/// both sides. `path_class` is known only when `RenderSettings::path_classes` is set, `light_group`
/// only in a `SceneWithLightGroups`.
struct TechniqueId {
  Technique technique;                             ///< which way
  std::int16_t s;                                  ///< light vertices
  std::int16_t t;                                  ///< camera vertices
  PathClass path_class = PathClass::unclassified;  ///< class of the path, where it is known
  std::uint16_t light_group = 0;                   ///< of the light that the path comes from, where it is known
};

/// The counts that weights use: κ, the expected number of samples of a technique at one place of a
/// path, and μ of merging. A technique that is off has the count 0 and then takes no part in any
/// weight.
template <std::floating_point T>
struct TechniqueCounts {
  T emitter_hit{};  ///< 1: a camera subpath hits a light
  T next_event{};   ///< 1: each camera vertex samples one point on a light
  T connect{};      ///< ρ: m n_L / V̄ for m vertices drawn from the cache of all trees, 1 for a paired tree
  T splat{};        ///< n_L: light trees whose vertices are connected with the camera, per camera subpath
  T merge{};        ///< μ = n_L π r²: light trees × area of the merging disk [scene units²]
  /// s(x_0) = 1: merging gathers the first vertices of light subpaths, too. False with a local
  /// count of merging.
  bool merges_first = true;
};

}  // namespace gmis
