#pragma once

#include "gmis/transport/render_engine.hpp"
#include "transport/furnace_scene.hpp"

/// \file
/// The engines for the furnace are the longest part of many tests to compile. Programs that link `gmis_furnace_engines` share
/// those of furnace_engines.cpp; without it this header declares nothing, and each program has its own.

#ifdef GMIS_SHARE_FURNACE_ENGINES
namespace gmis {

extern template void Engine<gmis_test::FurnaceScene<float>, CameraSide>::iterate(SerialExecutor&);
extern template void Engine<gmis_test::FurnaceScene<float>, BothSides>::iterate(SerialExecutor&);
extern template void Engine<gmis_test::FurnaceScene<float>, SplitTrees>::iterate(SerialExecutor&);
extern template void RenderPilot<gmis_test::FurnaceScene<float>>::EngineType::iterate(SerialExecutor&);

}  // namespace gmis
#endif
