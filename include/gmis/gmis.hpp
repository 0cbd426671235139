#pragma once

/// \file
/// The MIS core, the transport engine with the results that it fills, whole renderings, and the
/// built-in scene. Not in it: exact variances and other methods (gmis/mis/diagnostics.hpp,
/// gmis/mis/methods.hpp), tests of estimators with Catch2 (gmis/testing/catch.hpp), checks of an
/// adapter (gmis/check/check_scene.hpp), light trees that split
/// (gmis/transport/splitting/gmis_engines.hpp), replay (gmis/transport/replay/replay.hpp) and
/// threads (gmis/render/thread_executor.hpp).

#include "gmis/mis.hpp"
#include "gmis/render.hpp"
#include "gmis/result.hpp"
#include "gmis/scene.hpp"
#include "gmis/testing.hpp"
#include "gmis/transport.hpp"
