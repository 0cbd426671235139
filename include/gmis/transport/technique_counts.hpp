#pragma once

#include <concepts>

namespace gmis {

/// How many samples of each technique are expected at one place of a path (DESIGN: weights use nominal densities). A
/// technique that is off has the count 0; then it takes no part in any weight.
template <std::floating_point T>
struct TechniqueCounts {
  T emitter_hit{};  ///< 1: a camera subpath hits a light
  T next_event{};   ///< 1: each camera vertex samples one point on a light
  T connect{};      ///< ρ: expected connections of a camera vertex with the vertices of one light tree
  T splat{};        ///< n_L: light trees whose vertices are connected to the camera, per camera path of the pixel
  T merge{};        ///< n_L π r²: light trees times the area of the merging disk
};

}  // namespace gmis
