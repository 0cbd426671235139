#pragma once

/// \file
/// Everything: the MIS core and the transport engine with the results that it fills.

#include "gmis/mis.hpp"
#include "gmis/transport.hpp"
