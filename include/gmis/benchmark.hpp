#pragma once

/// \file
/// Sampling schemes and rounds of one's own side by side: variance, time, efficiency
/// (docs/time-your-scheme.md). Nothing is printed and no file is touched: results are texts.

#include "gmis/benchmark/compare.hpp"
#include "gmis/benchmark/contender.hpp"
