#pragma once

#include "gmis/render/ranks.hpp"

namespace gmis::tools {

/// gmis-render with this command line; returns its exit code. With several ranks, rank 0 alone
/// prints and writes files. A rank that fails while others render says so and returns 1: end the
/// others.
[[nodiscard]] int render_program(int argc, char** argv, const RanksRef& ranks = {});

}  // namespace gmis::tools
