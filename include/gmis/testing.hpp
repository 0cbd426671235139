#pragma once

/// \file
/// Tests of estimators, weights and samplers, in any test framework; docs/test-your-estimator.md
/// shows how. gmis/testing/catch.hpp has the same as matchers for Catch2 and is not included here.

#include "gmis/testing/check_estimator.hpp"
#include "gmis/testing/check_weights.hpp"
#include "gmis/testing/seeded.hpp"
