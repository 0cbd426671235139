#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

/// \file
/// Numbers of camera subpaths that are functions of the pixel. An iteration traces n(p) subpaths
/// for the pixel p and takes their mean, so that every iteration is a whole picture, and film and
/// error estimates need not know of the numbers. Weights have the nominal number, one.

namespace gmis {

/// The numbers of camera subpaths of all pixels of a frame. It is frozen while it is used.
class PixelCountTable {
 public:
  static constexpr std::uint32_t most = 8;  ///< largest count

  PixelCountTable() = default;
  /// One number per pixel of the frame, in [1, `most`].
  explicit PixelCountTable(std::vector<std::uint8_t> counts) : counts_(std::move(counts)) {}

  /// True when there is no table.
  [[nodiscard]] bool is_empty() const noexcept { return counts_.empty(); }
  /// True when the table is for a frame of `pixels` pixels, or empty.
  [[nodiscard]] bool fits(std::size_t pixels) const noexcept {
    return is_empty() ||
           (counts_.size() == pixels && std::all_of(counts_.begin(), counts_.end(),
                                                    [](std::uint8_t count) { return count >= 1 && count <= most; }));
  }
  /// Number of subpaths of a pixel (its index in the frame).
  [[nodiscard]] std::uint32_t operator[](std::size_t pixel) const noexcept { return counts_[pixel]; }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(counts_);
  }

 private:
  std::vector<std::uint8_t> counts_;
};

/// Camera subpaths in one iteration: how many a pixel has, and which points of its low-discrepancy
/// sequence are theirs. All subpaths of a pixel in one replication take points one after the other,
/// without a gap.
struct PixelSchedule {
  /// The numbers by pixel; null where every pixel has `uniform`.
  const PixelCountTable* table = nullptr;
  /// Number of subpaths of every pixel where there is no table. When it is above one, only the
  /// first takes a point.
  std::uint32_t uniform = 1;
  /// Earlier iterations of the replication in which a pixel took one point …
  std::uint64_t before = 0;
  /// … and those in which it had as many subpaths as now.
  std::uint64_t rounds = 0;

  /// Number of camera subpaths of a pixel (its index in the frame).
  [[nodiscard]] std::uint32_t count(std::size_t pixel) const noexcept {
    return table != nullptr ? (*table)[pixel] : uniform;
  }
  /// Index, in the sequence of the pixel, of the point that its first subpath takes.
  [[nodiscard]] std::uint64_t first_point(std::size_t pixel) const noexcept { return before + rounds * count(pixel); }
};

}  // namespace gmis
