#include "support/scene_engine.hpp"

template class gmis::Engine<gmis::tools::SceneType, gmis::SplitTrees>;
