#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, CameraSide>::iterate(tools::ThreadedExecutor&);

}  // namespace gmis
