#pragma once

#include <algorithm>
#include <limits>

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// An axis-aligned box; empty until something is added.
template <std::floating_point T>
struct Box {
  Vec3<T> lower{std::numeric_limits<T>::infinity()};
  Vec3<T> upper{-std::numeric_limits<T>::infinity()};

  void add(const Vec3<T>& point) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], point[axis]);
      upper[axis] = std::max(upper[axis], point[axis]);
    }
  }
  /// An empty box adds nothing.
  void add(const Box& box) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], box.lower[axis]);
      upper[axis] = std::max(upper[axis], box.upper[axis]);
    }
  }
  [[nodiscard]] bool is_empty() const noexcept { return !(lower.x <= upper.x); }
  /// Its faces belong to it.
  [[nodiscard]] bool contains(const Vec3<T>& point) const noexcept {
    for (int axis = 0; axis < 3; ++axis)
      if (!(point[axis] >= lower[axis] && point[axis] <= upper[axis])) return false;
    return true;
  }
  /// Half the surface area.
  [[nodiscard]] T half_area() const noexcept {
    if (is_empty()) return T(0);
    const Vec3<T> size = upper - lower;
    return size.x * size.y + size.y * size.z + size.z * size.x;
  }
};

}  // namespace gmis::scene
