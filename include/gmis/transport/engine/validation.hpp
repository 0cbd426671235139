#pragma once

#include <cmath>
#include <concepts>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/state/settings.hpp"

/// \file
/// The settings that an engine refuses before it does any work. `std::invalid_argument`
/// (core/argument_error.hpp) says what to change.

namespace gmis {

/// Returns `settings`. Throws when an engine for scenes of type `Sc`, with this method and this
/// source of numbers, cannot render a picture of this resolution with them. `split` holds the
/// settings of a method whose light trees split.
template <Scene Sc, class Method_, class Source, class SplitSettings>
GMIS_RARE const RenderSettings& validated(const RenderSettings& settings, glm::ivec2 resolution,
                                          const SplitSettings& split) {
  using T = ScalarOf<typename Sc::Spectrum>;
  using Split = typename Method_::template Split<T>;
  constexpr bool has_light_side = Method_::Weights::has_light_side;
  const SampleCounts& counts = settings.counts;
  constexpr double most_trees = 4294967296.0;  // the number of a tree is a 32-bit part of its random-number key
  constexpr int deepest = 256;
  const double pixels = static_cast<double>(resolution.x) * static_cast<double>(resolution.y);
  require_argument(resolution.x > 0 && resolution.y > 0,
                   "the camera has no pixels: its resolution must be 1x1 or more");
  require_argument(pixels < most_trees / 2.0, "the picture has 2^31 pixels or more: choose a smaller one");
  require_argument(
      settings.sampler == Sampler::independent || std::same_as<Source, SampleNumbers>,
      "RenderSettings::sampler asks for Sobol' points: they need the source SampleNumbers, the default; with "
      "another one choose Sampler::independent");
  require_argument(settings.max_depth >= 1 && settings.max_depth <= deepest,
                   "RenderSettings::max_depth must be from 1 to 256: the segments of the longest path");
  require_argument(counts.light_paths >= 0.0 && counts.light_paths * pixels < most_trees,
                   "SampleCounts::light_paths is negative or asks for 2^32 light trees or more: choose fewer");
  require_argument(counts.connections >= 0, "SampleCounts::connections must be 0 or more");
  require_argument(
      has_light_side || !counts.traces_light(),
      "this engine has no light side, but SampleCounts ask for light trees: use integrators::pt, or Engine<Scene>");
  require_argument(settings.alpha > 0.0 && settings.alpha <= 1.0,
                   "RenderSettings::alpha must be above 0 and at most 1");
  require_argument(!counts.has(Technique::merge) || counts.radius_factor > 0.0,
                   "SampleCounts::radius_factor must be above 0 when SampleCounts::merges is on");
  require_argument(
      !counts.has(Technique::merge) || !settings.radius || (*settings.radius > 0.0 && std::isfinite(*settings.radius)),
      "RenderSettings::radius is not above 0 and finite, but SampleCounts::merges is on: "
      "leave the radius unset for the default, or switch merging off");
  // The default radius follows the picture; the factor must be in range all the same.
  const auto widest = static_cast<T>(settings.radius.value_or(1.0) * counts.radius_factor);
  require_argument(!counts.has(Technique::merge) || std::isfinite(widest * widest),
                   "RenderSettings::radius times SampleCounts::radius_factor is too large for the scene's numbers");
  require_argument(settings.emission == Emission::power || GuidableLight<typename Sc::Light>,
                   "RenderSettings::emission is learned, but the scene's lights cannot be guided: they need "
                   "start_numbers and emission_along (core/guided_light.hpp)");
  if constexpr (requires { Split::template validate<typename Sc::Bsdf>(split, settings.max_depth); })
    Split::template validate<typename Sc::Bsdf>(split, settings.max_depth);
  return settings;
}

}  // namespace gmis
