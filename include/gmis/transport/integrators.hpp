#pragma once

#include "gmis/transport/sample_counts.hpp"

/// \file
/// The known integrators, each a set of counts for the one engine:
///
///     gmis::RenderSettings settings{.counts = gmis::integrators::bpt};
namespace gmis::integrators {

/// Vertex connection and merging: all techniques [Georgiev et al. 2012]. Where light trees split as well
/// (`RenderSettings::light_split`), it is the GMIS path sampler [Liu, Algorithm 1].
inline constexpr SampleCounts vcm{};
/// Path tracing with next-event estimation.
inline constexpr SampleCounts pt =
    vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::next_event; });
/// Light tracing: light vertices are connected with the camera; camera subpaths find only the lights that are seen
/// directly or through specular surfaces. Cannot make the light of other surfaces seen in a mirror or through glass.
inline constexpr SampleCounts lt = [] {
  SampleCounts counts = vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::splat; });
  counts.camera_children = 0;
  return counts;
}();
/// Path and light tracing together: no photon is kept, no two subpaths are connected. Enough for what light subpaths
/// find best, caustics on surfaces seen directly.
inline constexpr SampleCounts pt_lt =
    vcm.only([](Technique t) { return t != Technique::connect && t != Technique::merge; });
/// The same with photon mapping, which also makes caustics seen in a mirror: all techniques but connections.
inline constexpr SampleCounts pt_lt_pm = vcm.only([](Technique t) { return t != Technique::connect; });
/// Bidirectional path tracing.
inline constexpr SampleCounts bpt = vcm.only([](Technique t) { return t != Technique::merge; });
/// Stochastic progressive photon mapping: merging alone, at the first non-specular camera vertex
/// [Hachisuka, Jensen 2009].
inline constexpr SampleCounts ppm = [] {
  SampleCounts counts = vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::merge; });
  counts.camera_children = 0;
  return counts;
}();
/// Bidirectional photon mapping: merging at every camera vertex, weighted against each other and against emitter hits
/// [Vorba 2011].
inline constexpr SampleCounts bpm =
    vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::merge; });

}  // namespace gmis::integrators
