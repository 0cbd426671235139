#pragma once

#include <nlohmann/json.hpp>

namespace bench {

/// Time and error of an estimator's weights and of the recursive weights of a path in float, in double, and with the weights
/// alone in double: one object a row. `slice_seconds` and `slices` as in `nanoseconds_of`.
[[nodiscard]] nlohmann::ordered_json numbers_of_estimators(int slices, double slice_seconds);
[[nodiscard]] nlohmann::ordered_json numbers_of_path_weights(int slices, double slice_seconds);

}  // namespace bench
