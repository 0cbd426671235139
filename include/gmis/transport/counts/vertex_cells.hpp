#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "gmis/core/math.hpp"

namespace gmis {

/// Divides the vertices of camera subpaths into cells: by position, in 8 × 8 × 8 boxes whose sides hold equal numbers of the
/// vertices that they were made from, and by the axis that the normal is nearest to.
template <std::floating_point T>
class VertexCells {
 public:
  static constexpr std::size_t boxes = 8;                          ///< along one axis
  static constexpr std::size_t count = boxes * boxes * boxes * 6;  ///< cells

  /// One box. All limits are infinite.
  VertexCells() {
    for (auto& limits : limits_) limits.fill(std::numeric_limits<T>::infinity());
  }
  /// Boxes of vertices at these positions: the limits along each axis are quantiles. A far object moves no limit of the rest.
  explicit VertexCells(const std::vector<Vec3<T>>& positions) : VertexCells() {
    if (positions.empty()) return;
    std::vector<T> sorted(positions.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto place = static_cast<typename Vec3<T>::length_type>(axis);
      std::transform(positions.begin(), positions.end(), sorted.begin(), [place](const auto& p) { return p[place]; });
      std::sort(sorted.begin(), sorted.end());
      for (std::size_t k = 1; k < boxes; ++k) limits_[axis][k - 1] = sorted[sorted.size() * k / boxes];
    }
  }

  /// The cell of a vertex, below `count`. `normal` has any length and points to the side that the subpath came from.
  [[nodiscard]] std::size_t operator()(const Vec3<T>& position, const Vec3<T>& normal) const noexcept {
    const std::size_t box =
        (place(limits_[0], position.x) * boxes + place(limits_[1], position.y)) * boxes + place(limits_[2], position.z);
    const Vec3<T> size = glm::abs(normal);
    if (size.x >= size.y && size.x >= size.z) return box * 6 + (normal.x < T(0) ? 1 : 0);
    return size.y >= size.z ? box * 6 + (normal.y < T(0) ? 3 : 2) : box * 6 + (normal.z < T(0) ? 5 : 4);
  }

 private:
  using Limits = std::array<T, boxes - 1>;  // in increasing order

  /// Number of limits that are not above x.
  [[nodiscard]] static std::size_t place(const Limits& limits, T x) noexcept {
    std::size_t below = x >= limits[3] ? 4 : 0;
    below += x >= limits[below + 1] ? 2 : 0;
    return below + (x >= limits[below] ? 1 : 0);
  }

  std::array<Limits, 3> limits_;
};

}  // namespace gmis
