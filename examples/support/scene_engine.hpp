#pragma once

#include <cstdint>

#include "gmis/transport/output/replay.hpp"
#include "gmis/transport/render_engine.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"

/// \file
/// The engines for the built-in scene. Each is compiled once, in a source file of `engines/`, and not in every file that
/// renders.

namespace gmis::tools {

using SceneType = BuiltScene::SceneType;
using SceneSpectrum = SceneType::Spectrum;
using SceneEngine = RenderEngine<SceneType>;
using PilotEngine = RenderPilot<SceneType>::EngineType;

}  // namespace gmis::tools

namespace gmis {

extern template void Engine<tools::SceneType, CameraSide>::iterate(tools::ThreadedExecutor&);
extern template void Engine<tools::SceneType, BothSides>::iterate(tools::ThreadedExecutor&);
extern template void Engine<tools::SceneType, SplitTrees>::iterate(tools::ThreadedExecutor&);
extern template void Engine<tools::SceneType, CameraSide>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);
extern template void Engine<tools::SceneType, BothSides>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);
extern template void Engine<tools::SceneType, SplitTrees>::prepare_replay(tools::ThreadedExecutor&, std::uint32_t);
extern template ReplayedPath<tools::SceneSpectrum> replay(const Engine<tools::SceneType, BothSides>&, PathKind,
                                                          std::uint32_t);
extern template void tools::PilotEngine::iterate(tools::ThreadedExecutor&);

}  // namespace gmis
