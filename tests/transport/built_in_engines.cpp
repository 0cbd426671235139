#include "transport/built_in_engines.hpp"

namespace gmis {

template class Engine<scene::BvhScene<float>, CameraSide>;
template class Engine<scene::BvhScene<float>, BothSides>;
#ifndef GMIS_UNDER_SANITIZERS
template class Engine<scene::BvhScene<float>, SplitTrees>;
template class Engine<scene::BvhScene<float>, PilotMethod>;
template class Engine<scene::BvhScene<float>, CameraSide, gmis_test::ShiftedLattice>;
template class Engine<scene::BvhScene<float>, BothSides, gmis_test::ShiftedLattice>;
#endif

}  // namespace gmis
