#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/row_copy.hpp"

namespace gmis {

/// The root mean square bias of a disk over that of its change from half the radius, at a straight
/// edge of the light; where the light is smooth the ratio is 4/3. With g(t) = (arccos t − t √(1 −
/// t²)) / π, the share of a disk of radius 1 that lies beyond a line at the distance t, the bias is
/// ∓g(x/r), and the ratio √(∫ g(t)² dt / ∫ (g(t) − g(2 t))² dt).
inline constexpr double bias_of_change_at_edge = 2.0802;

/// The ratio of `bias_of_change_at_edge` where the light is smooth: the bias of a disk is
/// proportional to the square of its radius to first order [Hachisuka et al. 2010, eq. 6], so that
/// three quarters of it are gone at half the radius.
inline constexpr double bias_of_change_when_smooth = 4.0 / 3.0;

/// The ratio of `bias_of_change_at_edge` for the mean over a whole image. In the midst of a flat
/// surface a disk only moves light, which leaves the mean as it is; light is lost or added within
/// one radius of where a surface, or what is seen of it, ends. That is in proportion to the radius,
/// so that half of it is gone at half the radius.
inline constexpr double bias_of_change_of_mean = 2.0;

/// The bias of merging over a whole image, as a relative error.
struct MergingBias {
  /// √(mean over pixels of bias² / (value² + `relative_error_floor`)); 0 when noise hides it.
  double relative_bias = 0.0;
  /// √(standard error of `relative_bias`²); a bias below about twice this may be noise.
  double standard_error = 0.0;
  /// Bias of the mean over the image, relative: bias / value, below 0 where merging loses light. It
  /// is linear in the samples, and so rises from the noise long before `relative_bias` does.
  double of_mean = 0.0;
  /// Standard error of `of_mean`.
  double standard_error_of_mean = 0.0;
  /// The light that the run has added to make up for the bias of the mean
  /// (render/merging_gain.hpp), over the mean; `of_mean` is the bias that is left.
  double made_up = 0.0;

  /// Upper confidence bound: the squared bias plus two standard errors.
  [[nodiscard]] double bound() const noexcept {
    return std::sqrt(square(relative_bias) + 2.0 * square(standard_error));
  }
};

/// How merged light changes with the disk, summed over the iterations of a run: for every pixel,
/// what is merged minus what would be merged of the same photons in a disk of half the radius
/// (`Engine::merging_change`).
///
/// From the change follows the bias. Squares are products of two halves of the run, odd and even
/// iterations, which are independent: the mean of a product is the square of the mean, without any
/// variance.
class MergingChange {
 public:
  /// Pixels are stored by rows, from the first change on.
  explicit MergingChange(glm::ivec2 resolution) : resolution_(resolution) {}

  /// Adds the changes of one iteration, one per pixel; none where the iteration merged nothing.
  /// `gain`: what all that was merged has been multiplied with (`Engine::scale_merging`), above 0;
  /// the bias is that without it.
  void add_iteration(std::span<const float> change, double gain = 1.0) {
    const std::size_t half = (counts_[0] + counts_[1]) % 2;
    ++counts_[half];
    make_room_for(change.size());
    for (std::size_t p = 0; p < change.size(); ++p)
      if (std::isfinite(change[p])) sums_[half][p] += static_cast<double>(change[p]) / gain;
  }

  /// Takes in another run of the same size.
  void join(const MergingChange& other) {
    make_room_for(other.sums_[0].size());
    for (std::size_t half = 0; half < sums_.size(); ++half) {
      counts_[half] += other.counts_[half];
      for (std::size_t p = 0; p < other.sums_[half].size(); ++p) sums_[half][p] += other.sums_[half][p];
    }
  }

  /// Takes rows over from the same iterations of a picture of the same width.
  void copy_rows(const MergingChange& other, const RowCopy& rows) {
    counts_ = other.counts_;
    if (!other.has_merged()) return;
    make_room_for(static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y));
    for (std::size_t half = 0; half < sums_.size(); ++half)
      rows(other.sums_[half], sums_[half], static_cast<std::size_t>(resolution_.x));
  }

  /// True when there are two halves, or nothing was merged: then something can be said about the
  /// bias.
  [[nodiscard]] bool is_known() const noexcept { return !has_merged() || counts_[1] > 0; }

  /// The bias of `film`, which holds the mean of the same iterations; 0 when nothing was merged.
  /// Needs `is_known()`.
  ///
  /// Within a tile of 8 by 8 pixels the bias at an edge of a caustic changes its sign, and little
  /// of it is left; within one of 2 by 2 pixels more of it is. So there are two estimates: over
  /// large tiles with the ratio of smooth light, and over small ones with that of an edge. The one
  /// with the larger bound is returned. The standard error of a mean over tiles comes from the sum
  /// of the squares of the terms of large tiles: one photon is merged with several pixels, so that
  /// neighbours are not independent of each other; large tiles nearly are.
  template <Spectrum S>
  GMIS_RARE [[nodiscard]] MergingBias bias_of(const Film<S>& film) const {
    if (!has_merged()) return {};
    const std::vector<Tile> large = tiles_of(film, large_tile);
    const MergingBias smooth = bias_over_tiles(large, large_tile, bias_of_change_when_smooth);
    const MergingBias edges = bias_over_tiles(tiles_of(film, small_tile), small_tile, bias_of_change_at_edge);
    MergingBias larger = smooth.bound() > edges.bound() ? smooth : edges;
    add_bias_of_mean(large, larger);
    return larger;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(sums_[0], sums_[1], counts_[0], counts_[1]);
  }

 private:
  static constexpr int large_tile = 8, small_tile = 2;  // pixels

  [[nodiscard]] bool has_merged() const noexcept { return !sums_[0].empty(); }
  void make_room_for(std::size_t pixels) {
    if (pixels > 0 && !has_merged())
      for (std::vector<double>& half : sums_) half.assign(pixels, 0.0);
  }

  /// Sums over the pixels of a square.
  struct Tile {
    double value = 0.0, pixels = 0.0;
    std::array<double, 2> change{};  ///< mean of an iteration, in either half
  };

  [[nodiscard]] glm::ivec2 tile_counts(int side) const noexcept { return (resolution_ + side - 1) / side; }

  template <Spectrum S>
  [[nodiscard]] std::vector<Tile> tiles_of(const Film<S>& film, int side) const {
    const glm::ivec2 tiles = tile_counts(side);
    std::vector<Tile> sums(static_cast<std::size_t>(tiles.x) * static_cast<std::size_t>(tiles.y));
    std::size_t p = 0;
    for (int y = 0; y < resolution_.y; ++y)
      for (int x = 0; x < resolution_.x; ++x, ++p) {
        Tile& tile = sums[static_cast<std::size_t>(y / side * tiles.x + x / side)];
        for (int c = 0; c < Film<S>::channel_count; ++c) tile.value += film.mean(p, c) / Film<S>::channel_count;
        tile.pixels += 1.0;
        for (std::size_t half = 0; half < sums_.size(); ++half)
          tile.change[half] += sums_[half][p] / static_cast<double>(counts_[half]);
      }
    return sums;
  }

  /// Over `sums`, those of tiles of this width.
  [[nodiscard]] MergingBias bias_over_tiles(const std::vector<Tile>& sums, int side, double bias_of_change) const {
    const glm::ivec2 tiles = tile_counts(side), groups = tile_counts(large_tile);
    std::vector<double> of_groups(static_cast<std::size_t>(groups.x) * static_cast<std::size_t>(groups.y), 0.0);
    double pixels = 0.0;
    for (int y = 0; y < tiles.y; ++y)
      for (int x = 0; x < tiles.x; ++x) {
        const Tile& tile = sums[static_cast<std::size_t>(y * tiles.x + x)];
        of_groups[static_cast<std::size_t>(y * side / large_tile * groups.x + x * side / large_tile)] +=
            tile.pixels * tile.change[0] * tile.change[1] /
            (square(tile.value) + square(tile.pixels) * relative_error_floor);
        pixels += tile.pixels;
      }
    double sum = 0.0, squares = 0.0;
    for (const double of_group : of_groups) sum += of_group, squares += square(of_group);
    const double scale = square(bias_of_change) / pixels;
    MergingBias bias;
    bias.relative_bias = std::sqrt(std::max(0.0, scale * sum));
    bias.standard_error = std::sqrt(scale * std::sqrt(squares));
    return bias;
  }

  /// Adds what merging does to the mean. Its standard error comes from how far the halves are
  /// apart, in each large tile.
  static void add_bias_of_mean(const std::vector<Tile>& large, MergingBias& bias) noexcept {
    double value = 0.0, change = 0.0, squared_error = 0.0;
    for (const Tile& tile : large) {
      value += tile.value;
      change += 0.5 * (tile.change[0] + tile.change[1]);
      squared_error += square(0.5 * (tile.change[0] - tile.change[1]));
    }
    if (!(value > 0.0)) return;
    bias.of_mean = bias_of_change_of_mean * change / value;
    bias.standard_error_of_mean = bias_of_change_of_mean * std::sqrt(squared_error) / value;
  }

  glm::ivec2 resolution_{0, 0};
  std::array<std::vector<double>, 2> sums_;  ///< of odd and of even iterations; empty while nothing was merged
  std::array<std::uint32_t, 2> counts_{};
};

}  // namespace gmis
