#pragma once

#include <cstddef>

#include "gmis/benchmark.hpp"
#include "problems.hpp"

namespace bench {

/// Time, densities and error of the methods beyond the six schemes: a round is an estimate of 64
/// rounds of N samples, and 400 of them are measured. What a pilot of 30 rounds costs is in
/// neither; pairwise estimates and N3 need none.
[[nodiscard]] gmis::Comparison compare_methods(const Problem& problem, std::size_t n,
                                               const gmis::ComparisonSettings& settings);

}  // namespace bench
