#pragma once

#include "gmis/render/render_run.hpp"
#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "gmis/transport/splitting/split_trees.hpp"
#include "transport/furnace_scene.hpp"

/// \file
/// The engines for the furnace, and what runs them, are the longest part of many tests to compile.
/// Programs that link `gmis_furnace_engines` share those of furnace_engines.cpp; without it this
/// header declares nothing, and each program has its own.

#ifdef GMIS_SHARE_FURNACE_ENGINES
namespace gmis {

extern template class Engine<gmis_test::FurnaceScene<float>, CameraSide>;
extern template class Engine<gmis_test::FurnaceScene<float>, BothSides>;
extern template class Engine<gmis_test::FurnaceScene<float>, SplitTrees>;
extern template class Engine<gmis_test::FurnaceScene<float>, PilotMethod>;
extern template class AnyEngine<float>;
extern template class AnyPilot<float>;
extern template class RenderEngine<float>;
extern template class RenderRun<float>;

}  // namespace gmis
#endif
