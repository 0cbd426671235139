#pragma once

/// \file
/// Everything for simulating light transport over a scene of one's own (gmis/core/concepts.hpp says what it must offer).

#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/effects.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/result/film.hpp"
#include "gmis/transport/effects/effect_switches.hpp"
#include "gmis/transport/effects/plan.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/integrators.hpp"
#include "gmis/transport/render_engine.hpp"
#include "gmis/transport/weights/path_densities.hpp"
