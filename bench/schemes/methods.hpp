#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace bench {

/// Time, densities and variance of the methods beyond the six schemes, in rounds of N samples: one object a row. The
/// variance is measured between `repetitions` estimates of 64 rounds; what a pilot of 30 rounds costs is in neither. Pairwise
/// estimates and N3 need none. `error` is the mean squared error.
[[nodiscard]] nlohmann::ordered_json measured_methods(std::size_t largest, int slices, double slice_seconds,
                                                      std::uint64_t seed);

}  // namespace bench
