#include "support/scene_engine.hpp"

namespace gmis {

template void tools::PilotEngine::iterate(tools::ThreadedExecutor&);

}  // namespace gmis
