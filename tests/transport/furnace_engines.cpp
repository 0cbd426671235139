#include "transport/furnace_engines.hpp"

namespace gmis {

template void Engine<gmis_test::FurnaceScene<float>, CameraSide>::iterate(SerialExecutor&);
template void Engine<gmis_test::FurnaceScene<float>, BothSides>::iterate(SerialExecutor&);
template void Engine<gmis_test::FurnaceScene<float>, SplitTrees>::iterate(SerialExecutor&);
template void RenderPilot<gmis_test::FurnaceScene<float>>::EngineType::iterate(SerialExecutor&);

}  // namespace gmis
