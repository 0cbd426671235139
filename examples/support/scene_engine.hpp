#pragma once

#include "gmis/transport/allocation/engine_maker.hpp"
#include "gmis/transport/allocation/pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/splitting/split_trees.hpp"
#include "support/build_scene.hpp"

/// \file
/// The engines for the built-in scene. Each is compiled once, in a source file of `engines/`, and
/// not in every file that renders.

namespace gmis::tools {

using SceneType = BuiltScene::SceneType;
using SceneSpectrum = SceneType::Spectrum;
using SceneEngine = RenderEngine<SceneSpectrum>;
using PilotEngine = RenderPilot<SceneType>::EngineType;

}  // namespace gmis::tools

namespace gmis {

extern template class Engine<tools::SceneType, CameraSide>;
extern template class Engine<tools::SceneType, BothSides>;
extern template class Engine<tools::SceneType, SplitTrees>;
extern template class Engine<tools::SceneType, PilotMethod>;
extern template class AnyEngine<tools::SceneSpectrum>;
extern template class AnyPilot<tools::SceneSpectrum>;
extern template class RenderEngine<tools::SceneSpectrum>;

}  // namespace gmis
