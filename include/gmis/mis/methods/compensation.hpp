#pragma once

/// \file
/// MIS compensation lies in the core, since environment maps use it too.

#include "gmis/core/compensation.hpp"
