#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gmis/transport/effects/path_class.hpp"

namespace gmis {

enum class Technique : std::uint8_t { emitter_hit, next_event, connect, splat, merge };
inline constexpr std::size_t technique_count = 5;
inline constexpr std::array<Technique, technique_count> all_techniques{
    Technique::emitter_hit, Technique::next_event, Technique::connect, Technique::splat, Technique::merge};

/// Which technique made a path, with `s` light and `t` camera vertices; a merged vertex counts on both sides. The class of
/// the path is known where `RenderSettings::path_classes` is set.
struct TechniqueId {
  Technique technique;
  std::int16_t s;
  std::int16_t t;
  PathClass path_class = PathClass::unclassified;
};

/// The expected number of samples of each technique at one place of a path, as weights use it: κ of the techniques, μ of
/// merging. A technique that is off has the count 0; it then takes no part in any weight.
template <std::floating_point T>
struct TechniqueCounts {
  T emitter_hit{};  ///< 1: a camera subpath hits a light
  T next_event{};   ///< 1: each camera vertex samples one point on a light
  T connect{};      ///< ρ: expected connections of a camera vertex with the vertices of one light tree
  T splat{};        ///< n_L: light trees whose vertices are connected to the camera, per camera path of the pixel
  T merge{};        ///< n_L π r²: light trees times the area of the merging disk
};

}  // namespace gmis
