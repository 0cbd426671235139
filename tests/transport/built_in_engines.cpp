#include "transport/built_in_engines.hpp"

namespace gmis {

template void Engine<scene::BvhScene<float>, CameraSide>::iterate(SerialExecutor&);
template void Engine<scene::BvhScene<float>, BothSides>::iterate(SerialExecutor&);
template void Engine<scene::BvhScene<float>, SplitTrees>::iterate(SerialExecutor&);
template void Engine<scene::BvhScene<float>, CameraSide, gmis_test::ShiftedLattice>::iterate(SerialExecutor&);
template void Engine<scene::BvhScene<float>, BothSides, gmis_test::ShiftedLattice>::iterate(SerialExecutor&);

}  // namespace gmis
