#include "support/scene_engine.hpp"

namespace gmis {

template void Engine<tools::SceneType, SplitTrees>::iterate(tools::ThreadedExecutor&);
template void Engine<tools::SceneType, SplitTrees>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);

}  // namespace gmis
