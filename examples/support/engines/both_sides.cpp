#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, BothSides>::iterate(tools::ThreadedExecutor&);

}  // namespace gmis
