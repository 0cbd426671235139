#pragma once

/// \file
/// Everything: the MIS core, the transport engine, the results it fills, and the built-in scene.

#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/spectrum.hpp"
