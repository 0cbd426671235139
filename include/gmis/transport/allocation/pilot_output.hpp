#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/transport/allocation/forecast.hpp"
#include "gmis/transport/state/film_output.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"

/// \file
/// The sums that a pilot collects over a chunk of paths: for every pixel that it takes and every
/// candidate, the value of the pixel and the terms of its variance. Each contribution carries the
/// density of its path by each technique. pilot.hpp explains how the sums are used.

namespace gmis {

/// Selects the pixels that a pilot renders, and groups them in tiles. There are about 3 √(p n) of
/// them, with p the pixels of the crop and n the iterations of the run, at most 96 (longer runs
/// have more iterations of the pilot), and at least about `fewest_pixels`. More pixels make wrong
/// choices rarer, in inverse proportion; their cost over that of the run is in proportion to their
/// number; so the sum of both losses is least at a multiple of √(p n). The grid takes the pixel
/// at a hashed position in each group of `step()` consecutive pixels, since a picture may have rows
/// or columns that alternate.
class PilotGrid {
 public:
  static constexpr std::int64_t fewest_pixels = 1 << 10;

  PilotGrid() = default;
  /// `resolution` is that of the whole frame. Pixels are numbered in the whole frame, by rows from
  /// the upper left.
  PilotGrid(glm::ivec2 resolution, const PixelBounds& crop, std::uint32_t expected_iterations)
      : width_(static_cast<std::uint32_t>(resolution.x)),
        crop_(crop),
        size_(glm::max(crop.upper - crop.lower, glm::ivec2(0))) {
    const auto pixels = static_cast<std::int64_t>(size_.x) * size_.y;
    const double samples = static_cast<double>(pixels) * std::min(expected_iterations, 96U);
    const std::int64_t wanted = std::max<std::int64_t>(fewest_pixels, std::llround(3.0 * std::sqrt(samples)));
    step_ = static_cast<std::uint32_t>(std::max<std::int64_t>(1, pixels / wanted));
    tile_side_ = static_cast<int>(std::lround(8.0 * std::sqrt(static_cast<double>(step_))));
    tiles_ = (size_ + tile_side_ - 1) / tile_side_;
    is_taken_.resize(static_cast<std::size_t>(resolution.x) * static_cast<std::size_t>(resolution.y));
    std::uint32_t group = 0;
    for (std::int64_t first = 0; first < pixels; first += step_, ++group) {
      const std::uint32_t hash = (group ^ group >> 16U) * 0x85EBCA6BU;
      const std::int64_t number = first + (hash ^ hash >> 13U) % std::min<std::int64_t>(step_, pixels - first);
      const glm::ivec2 at = crop.lower + glm::ivec2(number % size_.x, number / size_.x);
      const std::size_t pixel = static_cast<std::size_t>(at.y) * width_ + static_cast<std::size_t>(at.x);
      is_taken_[pixel] = 1;
      taken_.push_back(static_cast<std::uint32_t>(pixel));
    }
  }
  /// Pixels in the crop for each one that is taken.
  [[nodiscard]] std::uint32_t step() const noexcept { return step_; }
  /// True when the pixel is taken.
  [[nodiscard]] bool takes(std::uint32_t pixel) const noexcept { return is_taken_[pixel] != 0; }
  /// The pixels that are taken, in increasing order.
  [[nodiscard]] std::span<const std::uint32_t> taken() const noexcept { return taken_; }
  /// Index in `taken()` of a pixel that is taken.
  [[nodiscard]] std::size_t index(std::uint32_t pixel) const noexcept {
    const glm::ivec2 at = place(pixel);
    return group(at.x, at.y);
  }
  /// Calls `visit` with the index in `taken()` of every pixel that is taken in the columns `first`
  /// to `last` of a row of the crop, from the left.
  template <class Visit>
  void for_each_in_row(int row, int first, int last, Visit&& visit) const {
    const auto start =
        static_cast<std::uint32_t>(row + crop_.lower.y) * width_ + static_cast<std::uint32_t>(crop_.lower.x);
    const auto from = start + static_cast<std::uint32_t>(first), to = start + static_cast<std::uint32_t>(last);
    for (std::size_t i = group(first, row); i <= group(last, row); ++i)
      if (taken_[i] >= from && taken_[i] <= to) visit(i);
  }
  /// Columns and rows of the crop.
  [[nodiscard]] glm::ivec2 size() const noexcept { return size_; }
  /// Column and row in the crop.
  [[nodiscard]] glm::ivec2 place(std::uint32_t pixel) const noexcept {
    return glm::ivec2(static_cast<int>(pixel % width_), static_cast<int>(pixel / width_)) - crop_.lower;
  }
  /// Index of the tile of a pixel, which must lie in the crop; bias is estimated per tile of about
  /// 64 pixels that are taken.
  [[nodiscard]] std::size_t tile(std::uint32_t pixel) const noexcept {
    const glm::ivec2 tile = place(pixel) / tile_side_;
    return static_cast<std::size_t>(tile.y * tiles_.x + tile.x);
  }
  [[nodiscard]] std::size_t tile_count() const noexcept { return static_cast<std::size_t>(tiles_.x * tiles_.y); }
  /// Half the width of a square of pixels around one, in which about 25 are taken.
  [[nodiscard]] int reach() const noexcept {
    return static_cast<int>(std::lround(2.5 * std::sqrt(static_cast<double>(step_)) - 0.5));
  }

 private:
  /// The group of `step()` pixels that holds this column and row of the crop.
  [[nodiscard]] std::size_t group(int column, int row) const noexcept {
    return (static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(size_.x) +
            static_cast<std::uint32_t>(column)) /
           step_;
  }

  std::uint32_t width_ = 1, step_ = 1;
  int tile_side_ = 8;
  PixelBounds crop_;
  glm::ivec2 size_{0, 0}, tiles_{0, 0};
  std::vector<std::uint8_t> is_taken_;  // of all pixels of the frame
  std::vector<std::uint32_t> taken_;    // one of each group
};

/// The candidates of a pilot, in lanes that are worked on at once: no compiler turned loops over
/// arrays of them into vector instructions, because of the branches in them.
struct PilotCandidates {
  static constexpr std::size_t lanes = 8;
  using Lanes GMIS_VECTOR_OF_BYTES(4 * lanes) = float;
  struct Block {
    PerTechnique<Lanes> factors{};  ///< counts divided by the counts of the pilot
    Lanes pair_scale{};    ///< factor on pairs of connections at one vertex: m draws give (m−1)/m of the squared mean
    Lanes disk{};          ///< area of the merging disk, divided by that of the pilot
    Lanes inverse_disk{};  ///< 1 / `disk`; 0 without merging
  };

  PilotGrid grid;
  SampleCounts made;  ///< the counts of the pilot: at least two connections, because pairs of them are needed
  std::size_t count = 0;
  std::vector<Block> blocks;

  void add(const SampleCounts& candidate) {
    const std::size_t lane = count++ % lanes;
    if (lane == 0) blocks.emplace_back();
    const PerTechnique<float> factors = count_factors<float>(candidate, made);
    for (std::size_t g = 0; g < technique_count; ++g) blocks.back().factors[g][lane] = factors[g];
    blocks.back().disk[lane] = static_cast<float>(disk_factor(candidate, made));
    blocks.back().inverse_disk[lane] = candidate.merges ? 1.0F / blocks.back().disk[lane] : 0.0F;
    const auto m = static_cast<float>(candidate.connections), made_m = static_cast<float>(made.connections);
    blocks.back().pair_scale[lane] = m > 0.0F ? (m - 1.0F) / m * made_m / (made_m - 1.0F) : 1.0F;
  }
};

/// Collects the sums of one chunk of paths for every candidate, and the pilot's own picture. Models
/// `ChunkOutput`.
template <Spectrum S>
class PilotOutput : public PathObserver {
 public:
  using T = ScalarOf<S>;

  /// A splat on a pixel that is taken. The pilot adds it to its pixel when all chunks are done.
  struct SplatRecord {
    std::uint32_t pixel;
    float value;
    TechniqueDensities<float> densities;
  };

  /// Starts the analysis for `candidates`, which must outlive this output.
  void analyse(const PilotCandidates* candidates) {
    candidates_ = candidates;
    sums_.resize(candidates->blocks.size());
  }

  [[nodiscard]] Counters& counters() noexcept { return film_.counters(); }
  [[nodiscard]] const Counters& counters() const noexcept { return film_.counters(); }
  [[nodiscard]] const RejectionLog& rejections() const noexcept { return film_.rejections(); }
  [[nodiscard]] auto splats() const noexcept { return std::span(film_.splats()); }
  void begin_trees(std::uint32_t first) noexcept { film_.begin_trees(first); }
  void reject(RejectionCause cause, const std::optional<TechniqueId>& technique) { film_.reject(cause, technique); }

  /// See `PathObserver`; true for every pixel before `analyse`.
  [[nodiscard]] bool takes(std::uint32_t pixel) const noexcept {
    return candidates_ == nullptr || candidates_->grid.takes(pixel);
  }

  void clear() {
    film_.clear();
    pixel_sums.clear();
    kernel_changes.clear();
    splat_records_.clear();
    missing.assign(candidates_ == nullptr ? 0 : candidates_->count, 0.0);
  }

  void begin_pixel(std::uint32_t pixel) {
    film_.begin_pixel(pixel);
    if (candidates_ != nullptr && pixel_sums.empty()) {
      // No spare room: memory that the process has not used before is slow at first.
      const PilotGrid& grid = candidates_->grid;
      std::size_t sums_in_row = 0;
      grid.for_each_in_row(grid.place(pixel).y, 0, grid.size().x - 1,
                           [&](std::size_t) { sums_in_row += candidates_->count; });
      pixel_sums.reserve(2 * sums_in_row);
      kernel_changes.reserve(sums_in_row);
    }
    std::fill(sums_.begin(), sums_.end(), Sums{});
  }
  /// Ends the techniques of a camera vertex. Scales the pairs of connections made there to each
  /// candidate's number of draws.
  void end_vertex() {
    if (!has_connections_) return;
    has_connections_ = false;
    for (std::size_t b = 0; b < sums_.size(); ++b) {
      Sums& sums = sums_[b];
      const Lanes pairs = sums.connect * sums.connect - sums.connect_squares;
      sums.second_moment += pairs * (candidates_->blocks[b].pair_scale - 1.0F);
      sums.connect = Lanes{};
      sums.connect_squares = Lanes{};
    }
  }

  /// Notes the squared distance of the vertices that are merged next, divided by the squared radius
  /// of the pilot.
  void on_merge(T relative_distance_squared) noexcept {
    film_.on_merge(relative_distance_squared);
    merge_distance_ = static_cast<float>(relative_distance_squared);
  }

  void add(TechniqueId id, const S& value, const TechniqueDensities<T>& densities) {
    film_.add(id, value, densities.weight());
    if (!is_finite(value)) return;
    const bool connects = id.technique == Technique::connect;
    const bool merges = id.technique == Technique::merge;
    has_connections_ = has_connections_ || connects;
    const Reweighted reweighted(single(value), single(densities));
    for (std::size_t b = 0; b < sums_.size(); ++b) {
      Sums& sums = sums_[b];
      const PilotCandidates::Block& block = candidates_->blocks[b];
      const Terms terms = reweighted.under(block);
      sums.value += terms.own;
      sums.second_moment += terms.second_moment - terms.own * terms.own;
      sums.missing += terms.missed;
      if (connects) {
        sums.connect += terms.own;
        sums.connect_squares += terms.own * terms.own;
      }
      if (merges) {
        // The pilot's disk stands for the candidate's in `own`. Here the kernels are those of the
        // candidate's disk and of one with half its radius, a quarter of its area.
        const Lanes whole = merge_distance_ <= block.disk ? Lanes{} + 1.0F : Lanes{};
        const Lanes half = 4.0F * merge_distance_ <= block.disk ? Lanes{} + 4.0F : Lanes{};
        sums.kernel_change += terms.own * block.inverse_disk * (whole - half);
      }
    }
  }

  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, const TechniqueDensities<T>& densities) {
    film_.add_splat(pixel, id, value, densities.weight());
    if (candidates_ == nullptr || !is_finite(value)) return;
    splat_records_.push_back({pixel, single(value), single(densities)});
  }

  [[nodiscard]] const S& take_pixel() {
    if (candidates_ != nullptr) keep_pixel();
    return film_.take_pixel();
  }

  /// `FilmOutput::merging_change`, for the pilot's own disk.
  [[nodiscard]] float merging_change() const noexcept { return film_.merging_change(); }
  /// `FilmOutput::merged_light`, for the pilot's pixels.
  [[nodiscard]] double merged_light() const noexcept { return film_.merged_light(); }

  [[nodiscard]] std::span<const SplatRecord> splat_records() const noexcept { return splat_records_; }

  /// One contribution, re-weighted for one candidate a lane.
  struct Terms {
    PilotCandidates::Lanes own;  ///< expected contribution of its technique under the candidate's counts and weights
    PilotCandidates::Lanes second_moment;  ///< term of ∫ f²/D
    /// Weighted value in the pilot when the candidate has no technique for the path; else 0.
    PilotCandidates::Lanes missed;
  };

  /// Calls `visit(candidate, Terms, lane)` for every candidate.
  template <class Visit>
  void for_each_candidate(const SplatRecord& record, Visit&& visit) const {
    const Reweighted reweighted(record.value, record.densities);
    for (std::size_t b = 0, c = 0; b < candidates_->blocks.size(); ++b) {
      const Terms terms = reweighted.under(candidates_->blocks[b]);
      for (std::size_t i = 0; i < lanes && c < candidates_->count; ++i, ++c) visit(c, terms, i);
    }
  }

  std::vector<double> missing;  ///< per candidate: light in the pixels that none of its techniques makes
  /// For each pixel two rows, one value per candidate: A, the contribution of the camera subpath,
  /// and the second moment, ∫ f²/D with the pairs of A.
  std::vector<float> pixel_sums;
  /// For each pixel and candidate, the merged part with the candidate's disk minus that with a disk
  /// of half the radius, all else equal.
  std::vector<float> kernel_changes;

 private:
  static constexpr std::size_t lanes = PilotCandidates::lanes;
  using Lanes = PilotCandidates::Lanes;

  /// Sums over the contributions of the current pixel.
  struct Sums {
    Lanes value{}, second_moment{}, missing{}, connect{}, connect_squares{}, kernel_change{};
  };

  /// One contribution, ready to be re-weighted for any candidate.
  class Reweighted {
   public:
    Reweighted(float value, const TechniqueDensities<float>& densities) noexcept
        : own_(static_cast<std::size_t>(densities.own)),
          value_(value),
          weighted_(densities.weight() * value),
          densities_(densities.relative) {}
    [[nodiscard]] GMIS_ALWAYS_INLINE Terms under(const PilotCandidates::Block& counts) const noexcept {
      const auto& f = counts.factors;
      Lanes total{};
      for (std::size_t t = 0; t < technique_count; ++t) total += f[t] * densities_[t];
      const auto is_made = total > 0.0F;
      const Lanes inverse = is_made ? 1.0F / (is_made ? total : Lanes{} + 1.0F) : Lanes{};
      const Lanes share = value_ * inverse;
      return {f[own_] * share, weighted_ * share, is_made ? Lanes{} : Lanes{} + weighted_};
    }

   private:
    std::size_t own_;
    float value_, weighted_;
    PerTechnique<float> densities_;
  };

  /// Mean of the channels, bounded so that its square is finite in float.
  [[nodiscard]] static float single(const S& value) noexcept {
    return static_cast<float>(std::min(mean_channel(value), T(1e15)));
  }
  [[nodiscard]] static TechniqueDensities<float> single(const TechniqueDensities<T>& densities) noexcept {
    TechniqueDensities<float> result{densities.own, {}};
    for (std::size_t g = 0; g < technique_count; ++g)
      result.relative[g] = static_cast<float>(std::min(densities.relative[g], T(1e30)));
    return result;
  }

  /// Stores the sums of the current pixel.
  void keep_pixel() {
    const std::size_t n = candidates_->count, start = pixel_sums.size();
    pixel_sums.resize(start + 2 * n);
    for (std::size_t c = 0; c < n; ++c) {
      const Sums& sums = sums_[c / lanes];
      const std::size_t i = c % lanes;
      pixel_sums[start + c] = sums.value[i];
      pixel_sums[start + n + c] = sums.second_moment[i] + square(sums.value[i]);
      kernel_changes.push_back(sums.kernel_change[i]);
      missing[c] += static_cast<double>(sums.missing[i]);
    }
  }

  FilmOutput<S> film_;
  const PilotCandidates* candidates_ = nullptr;
  std::vector<SplatRecord> splat_records_;
  std::vector<Sums> sums_;
  float merge_distance_ = 0.0F;  // as `on_merge` has it
  bool has_connections_ = false;
};

}  // namespace gmis
