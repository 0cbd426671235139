#pragma once

#include <concepts>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/transport/method.hpp"
#include "gmis/transport/settings.hpp"
#include "gmis/transport/walk/camera_subpath.hpp"

/// \file
/// What an engine refuses before it does any work. `std::invalid_argument` (core/argument_error.hpp) says what to change.

namespace gmis {

/// Refuses two tables of numbers of samples that would be learned at the same time.
inline void check_learned_counts(const RenderSettings& settings) {
  require_argument(
      settings.pixel_counts == PixelCounts::uniform || settings.vertex_counts == VertexCounts::uniform,
      "RenderSettings::pixel_counts and RenderSettings::vertex_counts are both learned: choose one of them");
}

/// Refuses settings that an engine for scenes of type `Sc`, with this method and this source of numbers, cannot render a picture of this
/// resolution with.
template <Scene Sc, class Method_, class Source>
void check_settings(const RenderSettings& settings, glm::ivec2 resolution) {
  using Split = typename Method_::template Split<ScalarOf<typename Sc::Spectrum>>;
  using Output = typename Method_::template Output<typename Sc::Spectrum>;
  constexpr bool has_light_side = Method_::Weights::has_light_side;
  const SampleCounts& counts = settings.counts;
  constexpr double most_trees = 4294967296.0;        // the number of a tree is a 32-bit part of its random-number key
  constexpr int deepest = 256, most_keys = 1 << 24;  // a vertex key has 24 bits (core/random.hpp)
  static_assert((16382 + 1) * detail::camera_numbers_per_child < most_keys);
  const double pixels = static_cast<double>(resolution.x) * static_cast<double>(resolution.y);
  require_argument(resolution.x > 0 && resolution.y > 0,
                   "the camera has no pixels: its resolution must be 1x1 or more");
  require_argument(pixels <= most_trees, "the picture has more than 2^32 pixels: choose a smaller one");
  require_argument(
      settings.sampler == Sampler::independent || std::same_as<Source, SampleNumbers>,
      "RenderSettings::sampler asks for Sobol' points: they need the source SampleNumbers, the default; with "
      "another one choose Sampler::independent");
  require_argument(settings.max_depth <= deepest, "RenderSettings::max_depth is above 256: choose 256 or less");
  require_argument(counts.light_paths >= 0.0 && counts.light_paths * pixels < most_trees,
                   "SampleCounts::light_paths is negative or asks for 2^32 light trees or more: choose fewer");
  require_argument(counts.connections >= paired_connections,
                   "SampleCounts::connections must be 0 or more, or paired_connections");
  require_argument(counts.camera_children >= 0 && counts.camera_children <= 16382,
                   "SampleCounts::camera_children must be between 0 and 16382");
  require_argument(
      has_light_side || !counts.traces_light(),
      "this engine has no light side, but SampleCounts ask for light trees: use integrators::pt, or Engine<Scene>");
  require_argument(settings.alpha > 0.0 && settings.alpha <= 1.0,
                   "RenderSettings::alpha must be above 0 and at most 1");
  require_argument(!counts.has(Technique::merge) || counts.radius_factor > 0.0,
                   "SampleCounts::radius_factor must be above 0 when SampleCounts::merges is on");
  require_argument(!counts.has(Technique::merge) || !settings.radius || *settings.radius > 0.0,
                   "RenderSettings::radius is not above 0, but SampleCounts::merges is on: "
                   "leave the radius unset for the default, or switch merging off");
  require_argument(settings.emission == Emission::power || GuidableLight<typename Sc::Light>,
                   "RenderSettings::emission is learned, but the scene's lights cannot be guided: they need "
                   "start_numbers and emission_along (core/guided_light.hpp)");
  require_argument(settings.vertex_counts == VertexCounts::uniform || !observes_children<Output>,
                   "RenderSettings::vertex_counts is learned, but this engine is that of a pilot: use uniform");
  require_argument(settings.pixel_counts == PixelCounts::uniform || !observes_children<Output>,
                   "RenderSettings::pixel_counts is learned, but this engine is that of a pilot: use uniform");
  check_learned_counts(settings);
  if constexpr (Split::splits_light) {
    require_argument(settings.vertex_counts == VertexCounts::uniform || counts.camera_children == 1,
                     "RenderSettings::vertex_counts is learned: an engine that splits light trees then needs "
                     "SampleCounts::camera_children 1");
    require_argument(settings.light_split != LightSplit::none || !counts.traces_light(),
                     "this engine splits light trees, but RenderSettings::light_split is none: use Engine<Scene>");
    require_argument(
        settings.light_tree_budget >= 1 &&
            (settings.light_tree_budget + 1.0) * settings.max_depth < static_cast<double>(most_keys),
        "RenderSettings::light_tree_budget must be 1 or more, and below 2^24 when multiplied by max_depth");
    require_argument(BsdfWithLobes<typename Sc::Bsdf> || settings.rounds > 1,
                     "the scene's BSDF names no lobes and RenderSettings::rounds is 1: no vertex would be split. "
                     "Model gmis::BsdfWithLobes, choose more rounds, or use Engine<Scene>");
  } else {
    require_argument(settings.light_split == LightSplit::none,
                     "RenderSettings::light_split asks for light trees that split: use Engine<Scene, SplitTrees>");
  }
}

}  // namespace gmis
