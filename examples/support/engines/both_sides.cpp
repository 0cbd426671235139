#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, BothSides>::iterate(tools::ThreadedExecutor&);
template void Engine<tools::SceneType, BothSides>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);

}  // namespace gmis
