#include "transport/furnace_engines.hpp"

namespace gmis {

template class Engine<gmis_test::FurnaceScene<float>, CameraSide>;
template class Engine<gmis_test::FurnaceScene<float>, BothSides>;
template class Engine<gmis_test::FurnaceScene<float>, SplitTrees>;
template class Engine<gmis_test::FurnaceScene<float>, PilotMethod>;
template class AnyEngine<float>;
template class AnyPilot<float>;
template class RenderEngine<float>;
template class RenderRun<float>;

}  // namespace gmis
