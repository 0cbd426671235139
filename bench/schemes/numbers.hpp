#pragma once

#include <string>
#include <vector>

#include "gmis/benchmark.hpp"

namespace bench {

/// Time and relative error of weights in one type of number.
struct NumbersRow {
  std::string what, numbers;
  double nanoseconds, error_rms, error_largest;
};

/// Time and error of an estimator's weights, and of the recursive weights of a path, in float, in
/// double, and with the weights alone in double.
[[nodiscard]] std::vector<NumbersRow> numbers_of_estimators(const gmis::ComparisonSettings& settings);
[[nodiscard]] std::vector<NumbersRow> numbers_of_path_weights(const gmis::ComparisonSettings& settings);

}  // namespace bench
