#pragma once

#include "gmis/scene/bvh_scene.hpp"
#include "gmis/transport/allocation/pilot.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/splitting/split_trees.hpp"
#include "transport/shifted_lattice.hpp"

/// \file
/// The engines for the built-in scene, as furnace_engines.hpp has those for the furnace: what links
/// `gmis_built_in_engines` shares those of built_in_engines.cpp. Tests under the sanitizers use two
/// of them.

#ifdef GMIS_SHARE_BUILT_IN_ENGINES
namespace gmis {

extern template class Engine<scene::BvhScene<float>, CameraSide>;
extern template class Engine<scene::BvhScene<float>, BothSides>;
#ifndef GMIS_UNDER_SANITIZERS
extern template class Engine<scene::BvhScene<float>, SplitTrees>;
extern template class Engine<scene::BvhScene<float>, PilotMethod>;
extern template class Engine<scene::BvhScene<float>, CameraSide, gmis_test::ShiftedLattice>;
extern template class Engine<scene::BvhScene<float>, BothSides, gmis_test::ShiftedLattice>;
#endif

}  // namespace gmis
#endif
