#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/transport/counts/vertex_cells.hpp"

/// \file
/// Numbers of samples that are functions of the vertex. These are the numbers really drawn: the nominal numbers, which weights
/// use, stay as they are, so no weight depends on them. A contribution is divided by the expected number of its samples.

namespace gmis {

/// The parts of the work at a camera vertex, each with a count of its own. `children`: how often the subpath goes on.
enum class VertexWork : std::uint8_t { next_event, connect, merge, children };
inline constexpr std::size_t vertex_work_count = 4;  ///< values of `VertexWork`

/// The expected numbers of samples at the vertices of camera subpaths. It is frozen while it is used.
///
/// With the importance T W of a vertex (its throughput over the value of the pixel, so that errors are relative) the best number
/// is n = T W λ √(V/C) above 1 and n = T W λ √(M/C) below, where V is the variance, M the second moment and C the cost of one sample
/// of the light that arrives, and λ² the cost of the picture over its variance [Rath et al. 2022, EARS].
template <std::floating_point T>
class CountTable {
 public:
  /// The factors of one cell, by `VertexWork`.
  struct alignas(8 * sizeof(T)) Entry {
    std::array<T, vertex_work_count> split{};     ///< λ √(V/C): 0 never splits
    std::array<T, vertex_work_count> roulette{};  ///< λ √(M/C): infinite for no roulette
  };
  static constexpr T most = T(8);  ///< largest count
  /// A roulette with a larger expected count would save less than it costs.
  static constexpr T least_saving = T(0.7);

  CountTable() = default;
  /// `entries` has one entry per cell, `pixel_scales` the scale W of every pixel of the frame. `least` is the smallest count, in
  /// [0.05, 1].
  CountTable(const VertexCells<T>& cells, std::vector<Entry> entries, std::vector<T> pixel_scales, T least)
      : cells_(cells), entries_(std::move(entries)), pixel_scales_(std::move(pixel_scales)), least_(least) {}

  /// True when there is no table.
  [[nodiscard]] bool is_empty() const noexcept { return entries_.empty(); }
  /// True when the table is for a frame of so many pixels, or empty.
  [[nodiscard]] bool fits(std::size_t pixels) const noexcept {
    return is_empty() || (entries_.size() == VertexCells<T>::count && pixel_scales_.size() == pixels);
  }
  /// The factors at a vertex.
  [[nodiscard]] const Entry& at(const Vec3<T>& position, const Vec3<T>& normal) const noexcept {
    return entries_[cells_(position, normal)];
  }
  /// The factors of a cell.
  [[nodiscard]] const Entry& at(std::size_t cell) const noexcept { return entries_[cell]; }
  /// W of a pixel.
  [[nodiscard]] T pixel_scale(std::size_t pixel) const noexcept { return pixel_scales_[pixel]; }

  /// The expected number of samples: 1, an integer up to `most`, or below `least_saving` any number from `least`. Above 1 it is the
  /// integer of least cost × variance: a random one would add variance of its own. 1 for an importance that is not a number.
  [[nodiscard]] T count(const Entry& entry, VertexWork work, T importance) const noexcept {
    const auto place = static_cast<std::size_t>(work);
    const T roulette = importance * entry.roulette[place];
    if (roulette < least_saving) return std::max(roulette, least_);
    const T split = importance * entry.split[place];
    if (!(split * split > T(2))) return T(1);
    if (split >= most) return most;
    // V/n + C n is the same for k and k + 1 samples where the best real number is √(k(k + 1)).
    const T below = std::floor(split);
    return split * split > below * (below + T(1)) ? below + T(1) : below;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(cells_, entries_, pixel_scales_, least_);
  }

 private:
  VertexCells<T> cells_;
  std::vector<Entry> entries_;
  std::vector<T> pixel_scales_;
  T least_ = T(1);
};

}  // namespace gmis
