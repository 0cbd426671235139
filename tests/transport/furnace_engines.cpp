#include "transport/furnace_engines.hpp"

namespace gmis {

template class Engine<gmis_test::FurnaceScene<float>, CameraSide>;
template class Engine<gmis_test::FurnaceScene<float>, BothSides>;
template class Engine<gmis_test::FurnaceScene<float>, SplitTrees>;
template class Engine<gmis_test::FurnaceScene<float>, PilotMethod>;

}  // namespace gmis
