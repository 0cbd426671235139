#pragma once

// The one place that knows which major version of Catch2 is here.
#if GMIS_CATCH2_MAJOR >= 3
#include <catch2/catch_all.hpp>
using Catch::Approx;
#else
#include <catch2/catch.hpp>
#endif
