#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "gmis/core/math.hpp"

namespace gmis {

/// Finds all points within a radius of a query: a hashed grid of cells, the points sorted by bucket.
///
/// A query visits exactly the points whose distance (as computed in `T`) is at most the radius, each once: several
/// cells of a query may fall into one bucket, so buckets are visited, not cells, and no bucket twice; the box around
/// all points only ends a query early when it is farther than the radius. Memory is kept from one build to the next.
template <std::floating_point T>
class LightVertexGrid {
 public:
  /// Sorts `count` points; `position(i)` gives point i, which queries call `name(i)`, by default i. The result does not
  /// depend on how many threads made the points.
  template <class Position, class Name = std::identity>
  void build(std::size_t count, T radius, Position&& position, Name&& name = {}) {
    radius_squared_ = radius * radius;
    lower_ = Vec3<T>(std::numeric_limits<T>::infinity());
    upper_ = -lower_;
    for (std::size_t i = 0; i < count; ++i) {
      lower_ = glm::min(lower_, Vec3<T>(position(i)));
      upper_ = glm::max(upper_, Vec3<T>(position(i)));
    }
    const Vec3<T> extent = count == 0 ? Vec3<T>(T(0)) : upper_ - lower_;
    const T largest_extent = std::max({extent.x, extent.y, extent.z});
    const Vec3<T> farthest = count == 0 ? Vec3<T>(T(0)) : glm::max(glm::abs(lower_), glm::abs(upper_));
    // Extend the reach beyond the radius by the rounding error of a cell coordinate or a distance.
    reach_ = radius + T(8) * std::numeric_limits<T>::epsilon() *
                          (radius + largest_extent + std::max({farthest.x, farthest.y, farthest.z}));
    // Cells of four times the reach keep the number of cells per query small. The lower bounds keep every coordinate in
    // int32.
    const T cell = std::max({cells_per_reach * reach_, largest_extent * T(0x1p-20), std::numeric_limits<T>::min()});
    inverse_cell_ = T(1) / cell;

    std::size_t bucket_count = 1;
    while (bucket_count < 2 * count) bucket_count *= 2;
    mask_ = static_cast<std::uint32_t>(bucket_count - 1);
    starts_.assign(bucket_count + 1, 0);
    bucket_of_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3<T> at = cell_coordinates(position(i));
      const std::uint32_t bucket =
          bucket_at(static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y), static_cast<std::int32_t>(at.z));
      bucket_of_[i] = bucket;
      ++starts_[bucket];
    }
    // Running sums make starts_[b] the end of bucket b. Filling from the back moves starts_[b] to the beginning of the
    // bucket and keeps the order of the points.
    for (std::size_t b = 1; b <= bucket_count; ++b) starts_[b] += starts_[b - 1];
    points_.resize(count);
    for (std::size_t i = count; i-- > 0;)
      points_[--starts_[bucket_of_[i]]] = {position(i), static_cast<std::uint32_t>(name(i))};
  }

  /// Calls `visit(name)` for every point within the radius of `at`. A non-finite `at` finds nothing.
  template <class Visit>
  void query(const Vec3<T>& at, Visit&& visit) const {
    const Vec3<T> outside = glm::max(lower_ - at, at - upper_);
    if (!(outside.x <= reach_ && outside.y <= reach_ && outside.z <= reach_)) return;
    const Vec3<T> low = cell_coordinates(at - Vec3<T>(reach_));
    const Vec3<T> high = cell_coordinates(at + Vec3<T>(reach_));
    const auto x0 = static_cast<std::int32_t>(low.x), x1 = static_cast<std::int32_t>(high.x);
    const auto y0 = static_cast<std::int32_t>(low.y), y1 = static_cast<std::int32_t>(high.y);
    const auto z0 = static_cast<std::int32_t>(low.z), z1 = static_cast<std::int32_t>(high.z);
    std::array<std::uint32_t, 27> visited;  // at most 2 cells per axis; rounding may make it 3
    std::size_t visited_count = 0;
    for (std::int32_t z = z0; z <= z1; ++z)
      for (std::int32_t y = y0; y <= y1; ++y)
        for (std::int32_t x = x0; x <= x1; ++x) {
          const std::uint32_t bucket = bucket_at(x, y, z);
          const std::uint32_t begin = starts_[bucket];
          const std::uint32_t end = starts_[bucket + 1];
          if (begin == end) continue;
          const auto visited_end = visited.begin() + static_cast<std::ptrdiff_t>(visited_count);
          if (std::find(visited.begin(), visited_end, bucket) != visited_end) continue;
          visited[visited_count++] = bucket;
          for (std::uint32_t i = begin; i < end; ++i) {
            const Vec3<T> offset = points_[i].position - at;
            if (glm::dot(offset, offset) <= radius_squared_) visit(points_[i].index);
          }
        }
  }

  /// Bytes of memory held.
  [[nodiscard]] std::size_t byte_count() const noexcept {
    return points_.capacity() * sizeof(Point) + (starts_.capacity() + bucket_of_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  static constexpr T cells_per_reach = T(4);

  struct Point {
    Vec3<T> position;
    std::uint32_t index;
  };

  [[nodiscard]] Vec3<T> cell_coordinates(const Vec3<T>& at) const noexcept {
    return glm::floor((at - lower_) * inverse_cell_);
  }
  [[nodiscard]] std::uint32_t bucket_at(std::int32_t x, std::int32_t y, std::int32_t z) const noexcept {
    const std::uint32_t mixed = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^
                                static_cast<std::uint32_t>(y) * 0xD8163841U ^
                                static_cast<std::uint32_t>(z) * 0xCB1AB31FU;
    return (mixed ^ (mixed >> 15U)) & mask_;
  }

  Vec3<T> lower_{std::numeric_limits<T>::infinity()}, upper_{-std::numeric_limits<T>::infinity()};
  T radius_squared_{}, reach_{}, inverse_cell_{};
  std::uint32_t mask_ = 0;
  std::vector<std::uint32_t> starts_ = {0, 0};
  std::vector<std::uint32_t> bucket_of_;
  std::vector<Point> points_;
};

}  // namespace gmis
