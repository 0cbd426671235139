#pragma once

/// \file
/// Everything: the MIS core, the transport engine with the results that it fills, whole renderings, and the built-in
/// scene.

#include "gmis/mis.hpp"
#include "gmis/render.hpp"
#include "gmis/result.hpp"
#include "gmis/scene.hpp"
#include "gmis/testing.hpp"
#include "gmis/transport.hpp"
