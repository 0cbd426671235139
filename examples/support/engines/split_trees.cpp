#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, SplitTrees>::iterate(tools::ThreadedExecutor&);

}  // namespace gmis
