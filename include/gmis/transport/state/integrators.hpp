#pragma once

#include "gmis/transport/state/sample_counts.hpp"

/// \file
/// The known integrators. Each one is a set of counts for the engine:
///
///     gmis::RenderSettings settings{.counts = gmis::integrators::bpt};
namespace gmis::integrators {

/// Vertex connection and merging: all techniques [Georgiev et al. 2012]. Over light trees that
/// split (`SplitTrees`) it is the GMIS path sampler [Liu, Algorithm 1].
inline constexpr SampleCounts vcm{};
/// `vcm` with a local count of merging: photons are the light vertices made from a surface with a
/// narrow lobe, where other techniques seldom find the path; the merging disk is 64 times as large
/// (docs/weights.md). In a scene without narrow lobes it is `bpt`.
inline constexpr SampleCounts vcm_local = [] {
  SampleCounts counts = vcm;
  counts.local_merges = true;
  counts.radius_factor = 8.0;
  return counts;
}();
/// Path tracing with next-event estimation.
inline constexpr SampleCounts pt =
    vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::next_event; });
/// Light tracing: light vertices are connected with the camera. Camera subpaths find only lights
/// that are seen directly, in mirrors or through glass. Light tracing cannot make other surfaces
/// seen in a mirror or through glass.
inline constexpr SampleCounts lt = [] {
  SampleCounts counts = vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::splat; });
  counts.extends_camera = false;
  return counts;
}();
/// Path tracing and light tracing together, without stored light vertices. Splats make caustics on
/// surfaces that are seen directly.
inline constexpr SampleCounts pt_lt =
    vcm.only([](Technique t) { return t != Technique::connect && t != Technique::merge; });
/// Path tracing, light tracing and photon mapping: all techniques except connections. Merging also
/// makes caustics that are seen in a mirror or through glass.
inline constexpr SampleCounts pt_lt_pm = vcm.only([](Technique t) { return t != Technique::connect; });
/// Bidirectional path tracing: all techniques except merging.
inline constexpr SampleCounts bpt = vcm.only([](Technique t) { return t != Technique::merge; });
/// Stochastic progressive photon mapping: merging alone, at the first non-specular camera vertex
/// [Hachisuka, Jensen 2009].
inline constexpr SampleCounts ppm = [] {
  SampleCounts counts = vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::merge; });
  counts.extends_camera = false;
  return counts;
}();
/// Bidirectional photon mapping [Vorba 2011]: merging at every non-specular camera vertex. The
/// merges of a path are weighted against each other and against the emitter hit.
inline constexpr SampleCounts bpm =
    vcm.only([](Technique t) { return t == Technique::emitter_hit || t == Technique::merge; });

}  // namespace gmis::integrators
