#pragma once

/// \file
/// A whole rendering in one call, over any scene: counts chosen by the effects of the scene and by
/// a pilot, iterations until a limit is met, error, price and pictures.

#include "gmis/render/automatic_request.hpp"
#include "gmis/render/declare_engines.hpp"
#include "gmis/render/render.hpp"
