#pragma once

/// \file
/// Your own sampling schemes and rounds side by side with those of the library: variance, time,
/// efficiency (docs/time-your-scheme.md). Nothing is printed and no file is touched: results are
/// texts.

#include "gmis/benchmark/compare.hpp"
#include "gmis/benchmark/contender.hpp"
