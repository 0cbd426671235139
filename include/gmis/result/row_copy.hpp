#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gmis {

/// Rows of one picture that are copied to another of the same width: `count` rows, from row `from`
/// on, to row `to` and below.
struct RowCopy {
  int from = 0, to = 0, count = 0;

  /// Copies them between two pictures whose rows have `row_length` values. `target` must have room.
  template <class Value>
  void operator()(const std::vector<Value>& source, std::vector<Value>& target, std::size_t row_length) const {
    const auto first = source.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(from) * row_length);
    const auto end = first + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(count) * row_length);
    std::copy(first, end, target.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(to) * row_length));
  }
};

}  // namespace gmis
