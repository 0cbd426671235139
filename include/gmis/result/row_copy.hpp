#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gmis {

/// Rows of one picture that become the first ones of another of the same width.
struct RowCopy {
  int from = 0;   ///< the first row, in the picture that they come from
  int count = 0;  ///< number of rows
  /// Copies them between two pictures whose rows have `row_length` values. `target` must have room.
  template <class Value>
  void operator()(const std::vector<Value>& source, std::vector<Value>& target, std::size_t row_length) const {
    const auto first = source.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(from) * row_length);
    const auto end = first + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(count) * row_length);
    std::copy(first, end, target.begin());
  }
};

}  // namespace gmis
