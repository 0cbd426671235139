#pragma once

#include <cstddef>
#include <vector>

namespace gmis::detail {

/// Makes `vector` hold `count` elements of unspecified values. Its capacity is the largest count
/// that was asked for, no more.
template <class X>
void resize_for_overwrite(std::vector<X>& vector, std::size_t count) {
  if (vector.capacity() < count) {
    vector = {};
    vector.reserve(count);
  }
  vector.resize(count);
}

}  // namespace gmis::detail
