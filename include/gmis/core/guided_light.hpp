#pragma once

#include "gmis/core/concepts.hpp"

namespace gmis {

/// A light whose emission can be guided (`RenderSettings::emission`). It has two optional members,
/// always both.
///
/// - `start_numbers(origin, direction)`: the numbers, in the unit square, from which
///   `sample_emission` makes the part of a start that it draws first: `uv_origin` of the point of a
///   light with a position, `uv_direction` of the direction of an infinite light, which ignores
///   `origin`. Nothing when this part is fixed or the light cannot tell.
/// - `emission_along(origin, direction)`: the start that `sample_emission` makes at `origin` along
///   `direction`, with the same weight and densities. An infinite light starts on the line through
///   `origin`. Nothing when `sample_emission` never makes this start.
template <class L>
concept GuidableLight = Light<L> && requires(const L& light, SurfacePoint<ScalarOf<typename L::Spectrum>> point,
                                             Vec3<ScalarOf<typename L::Spectrum>> w) {
  { light.start_numbers(point, w) } -> std::same_as<std::optional<Vec2<ScalarOf<typename L::Spectrum>>>>;
  { light.emission_along(point, w) } -> std::same_as<std::optional<EmissionSample<typename L::Spectrum>>>;
};

}  // namespace gmis
