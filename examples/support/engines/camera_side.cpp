#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, CameraSide>::iterate(tools::ThreadedExecutor&);
template void Engine<tools::SceneType, CameraSide>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);

}  // namespace gmis
