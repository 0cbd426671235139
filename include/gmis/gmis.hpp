#pragma once

/// \file
/// The MIS core with its exact variances, comparisons and tests of estimators, the transport engine
/// with the results that it fills, whole renderings, and the built-in scene. Not in it: methods
/// beyond the six schemes (gmis/mis/methods.hpp), tests of estimators with Catch2
/// (gmis/testing/catch.hpp), checks of an adapter (gmis/check/check_scene.hpp), light trees that
/// split (gmis/transport/splitting/gmis_engines.hpp), replay (gmis/transport/replay/replay.hpp) and
/// threads (gmis/render/thread_executor.hpp).

#include "gmis/benchmark.hpp"
#include "gmis/mis.hpp"
#include "gmis/render.hpp"
#include "gmis/result.hpp"
#include "gmis/scene.hpp"
#include "gmis/testing.hpp"
#include "gmis/transport.hpp"
