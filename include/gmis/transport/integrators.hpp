#pragma once

#include "gmis/transport/engine.hpp"

/// The integrators, each a list of techniques over the one engine.
namespace gmis::integrators {

/// Path tracing with next-event estimation.
using Pt = Integrator<Techniques<EmitterHit, NextEvent>>;
/// Bidirectional path tracing.
using Bpt = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat>>;
/// Vertex connection and merging.
using Vcm = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat, Merge>>;
/// Vertex connection and merging over trees of light subpaths [Liu, Algorithm 1]. Without splitting it *is* Vcm.
template <class Split = BudgetedSplit>
using Gmis = Integrator<Techniques<EmitterHit, NextEvent, Connect, Splat, Merge>, Split>;

}  // namespace gmis::integrators
