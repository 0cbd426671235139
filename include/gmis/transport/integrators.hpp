#pragma once

#include "gmis/transport/engine.hpp"

/// The integrators, each a list of techniques over the one engine.
namespace gmis::integrators {

/// Path tracing with next-event estimation.
using Pt = Integrator<Techniques<EmitterHit, NextEvent>>;
/// Light tracing: light vertices are connected with the camera; camera subpaths only find the lights that are seen
/// directly or through specular surfaces. Cannot make what is seen in a mirror or through glass.
using Lt = Integrator<Techniques<EmitterHit, Splat>, NoSplit, CameraWalk::specular>;
/// Path and light tracing together: no photon is kept, no two subpaths are connected. Enough for what light subpaths
/// find best, caustics on what is seen directly.
using PtLt = Integrator<Techniques<EmitterHit, NextEvent, Splat>>;
/// The same with photon mapping, which also makes caustics seen in a mirror: all techniques but connections.
using PtLtPm = Integrator<Techniques<EmitterHit, NextEvent, Splat, Merge>>;
/// Bidirectional path tracing.
using Bpt = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat>>;
/// Stochastic progressive photon mapping: merging alone, at the first non-specular camera vertex
/// [Hachisuka, Jensen 2009].
using Ppm = Integrator<Techniques<EmitterHit, Merge>, NoSplit, CameraWalk::specular>;
/// Bidirectional photon mapping: merging at every camera vertex, weighted against each other and against emitter hits
/// [Vorba 2011].
using Bpm = Integrator<Techniques<EmitterHit, Merge>>;
/// Vertex connection and merging.
using Vcm = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat, Merge>>;
/// Vertex connection and merging over trees of light subpaths [Liu, Algorithm 1]. Without splitting it *is* Vcm.
template <class Split = BudgetedSplit>
using Gmis = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat, Merge>, Split>;

/// `Base` with `RenderSettings::camera_children` children at the first non-specular vertex of a camera subpath.
template <class Base>
struct SplitCamera : Base {
  using Split = CameraSplit;
};

}  // namespace gmis::integrators
