#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/axis_lanes.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/math.hpp"
#include "gmis/transport/photons/resize_for_overwrite.hpp"

namespace gmis {

/// Finds all points within a radius of a query: a hashed grid of cells, the points sorted by
/// bucket.
///
/// Cells are long in y and z and short in x. The cells of one row, which have y and z in common,
/// follow each other in the table of buckets, so the cells of a row that a query reaches are one
/// range of points: mostly one or two rows are looked up, and an empty one costs two reads.
///
/// A query visits exactly the points whose distance (as computed in `T`) is at most the radius,
/// each once: rows may fall on each other in the table, so ranges of points are visited, not cells,
/// and no point of two ranges twice; the box around all points only ends a query early when it is
/// farther than the radius. Memory is kept from one build to the next, and is no larger than the
/// largest build asked for.
template <std::floating_point T>
class LightVertexGrid {
 public:
  /// Sorts `count` points; `position(i)` gives point i, which queries call `name(i)`, by default i.
  /// The result does not depend on the executor, nor on how many threads made the points.
  template <Executor E, class Position, class Name = std::identity>
  void build(E& executor, std::size_t count, T radius, Position&& position, Name&& name = {}) {
    const std::size_t chunk_count = (count + chunk_size - 1) / chunk_size;
    const auto for_chunks = [&](auto&& work) {
      executor.parallel_for(chunk_count, [&](std::size_t chunk) {
        work(chunk, chunk * chunk_size, std::min(count, (chunk + 1) * chunk_size));
      });
    };

    boxes_.resize(chunk_count);
    for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Box box;
      for (std::size_t i = begin; i < end; ++i) {
        box.lower = glm::min(box.lower, Vec3<T>(position(i)));
        box.upper = glm::max(box.upper, Vec3<T>(position(i)));
      }
      boxes_[chunk] = box;
    });
    lay_out(count, radius);

    // Sorted in two steps, so that threads share the work: by part of the table of buckets, then
    // each part by bucket. Both steps keep the order of the points within a bucket.
    const std::size_t bucket_count = std::size_t{mask_} + 1;
    const std::size_t part_count = chunk_count > 1 ? std::min<std::size_t>(256, bucket_count) : 1;
    const std::size_t part_size = bucket_count / part_count;  // both are powers of two
    detail::resize_for_overwrite(starts_, bucket_count + 1);
    detail::resize_for_overwrite(bucket_of_, count);
    detail::resize_for_overwrite(order_, count);
    detail::resize_for_overwrite(points_, count);
    part_ends_.assign(chunk_count * part_count + 1, 0);
    for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t bucket = bucket_of(position(i));
        bucket_of_[i] = bucket;
        ++part_ends_[bucket / part_size * chunk_count + chunk];
      }
    });
    for (std::size_t i = 1; i < part_ends_.size(); ++i) part_ends_[i] += part_ends_[i - 1];
    for_chunks([&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t i = end; i-- > begin;)
        order_[--part_ends_[bucket_of_[i] / part_size * chunk_count + chunk]] = static_cast<std::uint32_t>(i);
    });
    // part_ends_ has moved to the beginnings.
    executor.parallel_for(part_count, [&](std::size_t part) {
      const std::size_t first = part * part_size, last = first + part_size;
      const std::size_t begin = part_ends_[part * chunk_count];
      const std::size_t end = part + 1 < part_count ? part_ends_[(part + 1) * chunk_count] : count;
      for (std::size_t b = first; b < last; ++b) starts_[b] = 0;
      for (std::size_t k = begin; k < end; ++k) ++starts_[bucket_of_[order_[k]]];
      // Running sums make starts_[b] the end of bucket b. Filling from the back moves starts_[b] to
      // the beginning of the bucket.
      auto sum = static_cast<std::uint32_t>(begin);
      for (std::size_t b = first; b < last; ++b) starts_[b] = sum += starts_[b];
      for (std::size_t k = end; k-- > begin;) {
        const std::size_t i = order_[k];
        points_[--starts_[bucket_of_[i]]] = {position(i), static_cast<std::uint32_t>(name(i))};
      }
    });
    starts_[bucket_count] = static_cast<std::uint32_t>(count);
  }

  /// Calls `visit(name)` for every point within the radius of `at`. A non-finite `at` finds
  /// nothing.
  template <class Visit>
  void query(const Vec3<T>& at, Visit&& visit) const {
    const auto lanes = AxisLanes<T>::of(at), reach = AxisLanes<T>::all(reach_);
    if (!are_at_most(lower_ - lanes, lanes - upper_, reach_)) return;
    const auto low = cell_coordinates(lanes - reach), high = cell_coordinates(lanes + reach);
    const std::int32_t x0 = low[0], x1 = high[0], y0 = low[1], y1 = high[1], z0 = low[2], z1 = high[2];
    Ranges ranges;
    const auto add_row = [&](std::int32_t y, std::int32_t z) {
      const std::uint32_t first = bucket_at(x0, y, z);
      const std::uint32_t last = first + static_cast<std::uint32_t>(x1 - x0);
      if (last <= mask_) [[likely]] {
        ranges.add(starts_[first], starts_[last + 1]);
      } else {  // the row goes on at the beginning of the table
        ranges.add(starts_[first], starts_[mask_ + 1]);
        ranges.add(starts_[0], starts_[(last & mask_) + 1]);
      }
    };
    if (y0 == y1 && z0 == z1) [[likely]]
      add_row(y0, z0);
    else
      for (std::int32_t z = z0; z <= z1; ++z)
        for (std::int32_t y = y0; y <= y1; ++y) add_row(y, z);
    for (const Range& range : ranges.all())
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        const Vec3<T> offset = points_[i].position - at;
        if (glm::dot(offset, offset) <= radius_squared_) visit(points_[i].name);
      }
  }

  /// Bytes of memory held.
  [[nodiscard]] constexpr std::size_t byte_count() const noexcept {
    return points_.capacity() * sizeof(Point) + boxes_.capacity() * sizeof(Box) +
           (starts_.capacity() + bucket_of_.capacity() + order_.capacity() + part_ends_.capacity()) *
               sizeof(std::uint32_t);
  }

 private:
  static constexpr std::size_t chunk_size = 4096;
  /// Edges of a cell in units of the reach: a query spans two cells of a row or, by rounding,
  /// three, and mostly one row.
  static constexpr T row_step = T(2), row_width = T(8);
  /// More than the cells of a row that a query spans, so that no bucket is visited twice in one
  /// row.
  static constexpr std::size_t fewest_buckets = 8;

  struct Point {
    Vec3<T> position;
    std::uint32_t name;
  };
  struct Box {
    Vec3<T> lower{std::numeric_limits<T>::infinity()}, upper{-std::numeric_limits<T>::infinity()};
  };

  /// Points from `begin` to `end` − 1.
  struct Range {
    std::uint32_t begin, end;
  };
  /// The points near one query: ranges without a common point.
  class Ranges {
   public:
    /// Adds what is in no range before: different cells may have the same bucket.
    void add(std::uint32_t begin, std::uint32_t end) noexcept {
      const std::span<const Range> before = all();
      while (begin < end) {
        std::uint32_t to = end, known_to = begin;
        for (const Range& other : before)
          if (begin < other.begin)
            to = std::min(to, other.begin);
          else
            known_to = std::max(known_to, other.end);
        if (known_to == begin) ranges_[count_++] = {begin, to}, known_to = to;
        begin = known_to;
      }
    }
    [[nodiscard]] std::span<const Range> all() const noexcept { return {ranges_.data(), count_}; }

   private:
    // At most 3 × 3 rows, each in one or two pieces, have 36 ends, between which there are at most
    // 35 ranges.
    std::array<Range, 35> ranges_;
    std::size_t count_ = 0;
  };

  /// Sets the box, the size of cells and the number of buckets.
  void lay_out(std::size_t count, T radius) {
    radius_squared_ = radius * radius;
    Box box;
    for (const Box& part : boxes_) box = {glm::min(box.lower, part.lower), glm::max(box.upper, part.upper)};
    lower_ = AxisLanes<T>::of(box.lower);
    upper_ = AxisLanes<T>::of(box.upper);
    const Vec3<T> extent = count == 0 ? Vec3<T>(T(0)) : box.upper - box.lower;
    const T largest_extent = std::max({extent.x, extent.y, extent.z});
    const Vec3<T> farthest = count == 0 ? Vec3<T>(T(0)) : glm::max(glm::abs(box.lower), glm::abs(box.upper));
    // Extend the reach beyond the radius by the rounding error of a cell coordinate or a distance.
    reach_ = radius + T(8) * std::numeric_limits<T>::epsilon() *
                          (radius + largest_extent + std::max({farthest.x, farthest.y, farthest.z}));
    // The lower bounds keep every coordinate in int32.
    const T smallest = std::max(largest_extent * T(0x1p-20), std::numeric_limits<T>::min());
    const T step = std::max(row_step * reach_, smallest), width = std::max(row_width * reach_, smallest);
    inverse_cell_ = AxisLanes<T>::of({T(1) / step, T(1) / width, T(1) / width});
    std::size_t bucket_count = fewest_buckets;
    while (bucket_count < 2 * count) bucket_count *= 2;
    mask_ = static_cast<std::uint32_t>(bucket_count - 1);
  }

  [[nodiscard]] AxisArray<std::int32_t> cell_coordinates(const AxisLanes<T>& at) const noexcept {
    return ((at - lower_) * inverse_cell_).floors();
  }
  [[nodiscard]] constexpr std::uint32_t bucket_at(std::int32_t x, std::int32_t y, std::int32_t z) const noexcept {
    std::uint32_t row = static_cast<std::uint32_t>(y) * 0xD8163841U ^ static_cast<std::uint32_t>(z) * 0xCB1AB31FU;
    row ^= row >> 15U;
    return (row + static_cast<std::uint32_t>(x)) & mask_;
  }
  [[nodiscard]] std::uint32_t bucket_of(const Vec3<T>& at) const noexcept {
    const auto cell = cell_coordinates(AxisLanes<T>::of(at));
    return bucket_at(cell[0], cell[1], cell[2]);
  }

  AxisLanes<T> lower_ = AxisLanes<T>::of(Box().lower), upper_ = AxisLanes<T>::of(Box().upper);
  AxisLanes<T> inverse_cell_ = AxisLanes<T>::all(T(0));
  T radius_squared_{}, reach_{};
  std::uint32_t mask_ = fewest_buckets - 1;
  std::vector<std::uint32_t> starts_ = std::vector<std::uint32_t>(fewest_buckets + 1, 0);
  std::vector<Point> points_;
  // Used while building.
  std::vector<Box> boxes_;
  std::vector<std::uint32_t> bucket_of_, order_, part_ends_;
};

}  // namespace gmis
