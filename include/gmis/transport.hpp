#pragma once

/// \file
/// Light transport over your own scene (gmis/core/concepts.hpp says what it must offer): the
/// engine, the known integrators and the techniques that a scene needs. Two parts stand in headers
/// of their own, because they take long to compile: the pilot that chooses counts
/// (gmis/transport/allocation/engines_with_pilot.hpp, part of gmis/render.hpp) and light trees that
/// split (gmis/transport/splitting/gmis_engines.hpp).

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/result/film.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/plan/effect_switches.hpp"
#include "gmis/transport/plan/plan.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "gmis/transport/weights/path_densities.hpp"
