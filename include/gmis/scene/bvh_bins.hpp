#pragma once

#include <span>

#include "gmis/scene/bounds.hpp"
#include "gmis/scene/bvh.hpp"

/// \file
/// The surface area heuristic over bins of centroids: where to cut a range of primitives in two.

namespace gmis::scene {

/// A primitive while the tree is built: its box, its kind and its number among those of its kind.
/// 32 bytes in float.
template <std::floating_point T>
struct alignas(16) BvhItem {
  std::array<T, 3> lower;
  std::uint32_t index;
  std::array<T, 3> upper;
  BvhChild::Kind kind;

  BvhItem() noexcept {
  }  // NOLINT: left uninitialised, so that the threads that write it first also touch its memory first

  [[nodiscard]] Bounds<T> bounds() const noexcept {
    return {Quad<T>::of(lower[0], lower[1], lower[2]), Quad<T>::of(upper[0], upper[1], upper[2])};
  }
};

#if defined(__SSE2__)
template <>
[[nodiscard]] inline Bounds<float> BvhItem<float>::bounds() const noexcept {
  // The fourth number is no number: as one it might be denormal, and slow.
  const __m128 three = _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0));
  const auto load = [&](const std::array<float, 3>& at) {
    return Quad<float>{_mm_and_ps(three, _mm_load_ps(at.data()))};
  };
  return {load(lower), load(upper)};
}
#endif

/// Twice the centroid of a box.
template <std::floating_point T>
[[nodiscard]] inline Quad<T> doubled_centroid(const Bounds<T>& box) noexcept {
  return box.lower + box.upper;
}

/// Sixteen bins along each axis over the (doubled) centroids of a range.
template <std::floating_point T>
class BvhBinGrid {
 public:
  static constexpr std::size_t bin_count = 16;

  explicit BvhBinGrid(const Bounds<T>& centroids) noexcept : lower_(centroids.lower) {
    const Quad<T> extent = centroids.upper - centroids.lower;
    const auto scale = [&](std::size_t axis) { return extent[axis] > T(0) ? T(bin_count) / extent[axis] : T(0); };
    scale_ = Quad<T>::of(scale(0), scale(1), scale(2));
  }
  /// The bin of a box along each axis; 0 along an axis on which all centroids are equal.
  [[nodiscard]] std::array<std::int32_t, 4> bins_of(const Bounds<T>& box) const noexcept {
    const Quad<T> scaled = (doubled_centroid(box) - lower_) * scale_;
    return maximum(minimum(scaled, Quad<T>::all(T(bin_count - 1))), Quad<T>::all(T(0))).truncated();
  }

 private:
  Quad<T> lower_, scale_;
};

/// Where to cut: the items in the bins up to `last_bin` along `axis` go to the left. `axis` −1: no
/// cut separates anything.
template <std::floating_point T>
struct BvhCut {
  T cost = std::numeric_limits<T>::infinity();  ///< half the area × packets, of both sides
  int axis = -1;
  std::size_t last_bin = 0;
};

template <std::floating_point T>
class BvhBins {
 public:
  void add(std::span<const BvhItem<T>> items, const BvhBinGrid<T>& grid) noexcept {
    for (const BvhItem<T>& item : items) {
      const Bounds<T> box = item.bounds();
      const auto at = grid.bins_of(box);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Bin& bin = bins_[axis][static_cast<std::size_t>(at[axis])];
        bin.box.add(box);
        ++(item.kind == BvhChild::triangles ? bin.triangles : bin.spheres);
      }
    }
  }
  void add(const BvhBins& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t bin = 0; bin < bin_count; ++bin) bins_[axis][bin].add(other.bins_[axis][bin]);
  }

  [[nodiscard]] BvhCut<T> best_cut() const noexcept {
    BvhCut<T> best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<T, bin_count> cost_above;
      Bin above;
      for (std::size_t bin = bin_count - 1; bin > 0; --bin) {
        above.add(bins_[axis][bin]);
        cost_above[bin] = above.cost();
      }
      Bin below;
      for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
        below.add(bins_[axis][bin]);
        // Infinite or not a number where one side is empty.
        const T cost = below.cost() + cost_above[bin + 1];
        if (cost < best.cost) best = {cost, static_cast<int>(axis), bin};
      }
    }
    return best;
  }

  /// The boxes of the two sides of a cut.
  [[nodiscard]] std::array<Bounds<T>, 2> boxes(const BvhCut<T>& cut) const noexcept {
    std::array<Bounds<T>, 2> result;
    for (std::size_t bin = 0; bin < bin_count; ++bin)
      result[bin <= cut.last_bin ? 0 : 1].add(bins_[static_cast<std::size_t>(cut.axis)][bin].box);
    return result;
  }

 private:
  static constexpr std::size_t bin_count = BvhBinGrid<T>::bin_count;
  struct Bin {
    Bounds<T> box;
    std::uint32_t triangles = 0, spheres = 0;

    void add(const Bin& other) noexcept {
      box.add(other.box);
      triangles += other.triangles;
      spheres += other.spheres;
    }
    [[nodiscard]] T cost() const noexcept { return box.half_area() * (packets(triangles) + packets(spheres)); }
    [[nodiscard]] static T packets(std::uint32_t count) noexcept {
      return static_cast<T>(static_cast<std::int32_t>((count + lane_count - 1) / lane_count));
    }
  };
  std::array<std::array<Bin, bin_count>, 3> bins_;
};

}  // namespace gmis::scene
