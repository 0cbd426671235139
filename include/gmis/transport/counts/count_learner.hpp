#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/transport/counts/crop_pixels.hpp"
#include "gmis/transport/counts/learn_counts.hpp"

namespace gmis {

/// Learns a `CountTable` from the first iterations of a run. These iterations have one sample of everything and are part of the
/// picture as usual. The same bits for any number of threads.
template <std::floating_point T>
class CountLearner {
 public:
  static constexpr std::uint32_t iterations = 4;                   ///< that it learns from
  static constexpr std::size_t most_paths = std::size_t{1} << 15;  ///< about that many subpaths are logged in all
  /// A table is used when it is predicted to make variance × cost at most this times as large.
  static constexpr double most_work = 0.95;
  /// Smallest count. A roulette with less saves little more, and makes fireflies where samples of much light are rare.
  static constexpr T least_count = T(0.25);

  CountLearner() = default;
  /// For the pixels of a crop.
  explicit CountLearner(const CropPixels& crop) : crop_(crop), logs_(crop.height) {
    sums_.assign(crop.frame_size(), 0.0);
    squares_ = sums_;
    stride_ = std::max<std::size_t>(1, (crop.size() * iterations + most_paths - 1) / most_paths);
  }

  /// Iterations so far.
  [[nodiscard]] std::uint32_t seen() const noexcept { return seen_; }
  /// The log of a row of the crop.
  [[nodiscard]] VertexLog<T>& log(std::size_t row) noexcept { return logs_[row]; }
  /// True when the subpath of this pixel is logged in the present iteration: every pixel in one of `stride_` iterations.
  [[nodiscard]] bool is_logged(std::size_t pixel) const noexcept {
    return (pixel % crop_.frame_width + pixel / crop_.frame_width + seen_) % stride_ == 0;
  }

  /// Ends an iteration with this picture. `cost` is that of all its work, in the unit of `vertex_costs`.
  template <Spectrum S>
  void end_iteration(std::span<const S> frame, double cost) {
    for (std::size_t pixel = 0; pixel < frame.size(); ++pixel) {
      const auto value = static_cast<double>(mean_channel(frame[pixel]));
      sums_[pixel] += value;
      squares_[pixel] += square(value);
    }
    for (const VertexLog<T>& log : logs_) records_.insert(records_.end(), log.records().begin(), log.records().end());
    crop_.for_each([&](std::size_t pixel) { paths_ += is_logged(pixel) ? 1.0 : 0.0; });
    cost_ += cost;
    ++seen_;
    if (seen_ == iterations / 2) half_ = records_.size(), half_paths_ = paths_;
  }

  /// The table, after `iterations`; nothing when it would gain little. Of four values around λ, with and without splitting, and the counts 1, the best by what
  /// half of the subpaths predict for a table from the other half.
  [[nodiscard]] std::optional<CountTable<T>> table() {
    const std::vector<T> scales = pixel_scales();
    const IterationFigures made = figures(scales);
    if (!(made.variance > 0.0) || !(made.cost > 0.0) || records_.empty()) return std::nullopt;
    std::vector<Vec3<T>> positions;
    const std::size_t step = std::max<std::size_t>(1, records_.size() / 4096);
    for (std::size_t i = 0; i < records_.size(); i += step) positions.push_back(records_[i].position);
    const VertexCells<T> cells(positions);
    for (VertexRecord<T>& record : records_)
      record.cell = static_cast<std::uint32_t>(cells(record.position, record.normal));
    const std::span<const VertexRecord<T>> all(records_);
    const std::array halves{all.first(half_), all.subspan(half_)};
    const std::array paths{half_paths_, paths_ - half_paths_};
    const std::array statistics{statistics_of<T>(halves[0], borrowed), statistics_of<T>(halves[1], borrowed)};
    const double lambda = std::sqrt(made.cost / made.variance);
    struct {
      double work = most_work, lambda = 0.0;
      bool splits = false;
    } best;
    for (const bool splits : {false, true})
      for (const double factor : {0.5, 0.8, 1.25, 2.0}) {
        double work = 0.0;
        for (const std::size_t half : {0U, 1U}) {
          const CountTable<T> table(cells, entries_of<T>(statistics[half], factor * lambda, splits), scales,
                                    least_count);
          const IterationFigures after = predict<T>(table, statistics[half], halves[1 - half], paths[1 - half], made);
          work += 0.5 * after.variance * after.cost / (made.variance * made.cost);
        }
        if (work < best.work) best = {work, factor * lambda, splits};
      }
    if (best.lambda == 0.0) return std::nullopt;
    return CountTable<T>(cells, entries_of<T>(statistics_of<T>(all, borrowed), best.lambda, best.splits), scales,
                         least_count);
  }

  /// Relative variance and cost of an iteration with one sample of everything.
  [[nodiscard]] IterationFigures figures(const std::vector<T>& scales) const {
    const double n = seen_;
    std::vector<double> variances;
    crop_.for_each([&](std::size_t pixel) {
      const double mean = sums_[pixel] / n;
      variances.push_back((squares_[pixel] / n - square(mean)) * n / (n - 1.0) *
                          square(static_cast<double>(scales[pixel])));
    });
    const double pixels = static_cast<double>(std::max<std::size_t>(1, variances.size()));
    return {trimmed_mean(variances, 1), cost_ / n / pixels};
  }
  /// W of every pixel (`CropPixels::scales`).
  [[nodiscard]] std::vector<T> pixel_scales() const {
    return crop_.template scales<T>([&](std::size_t pixel) { return sums_[pixel] / seen_; });
  }
  /// The logged vertices, path by path.
  [[nodiscard]] std::span<const VertexRecord<T>> records() const noexcept { return records_; }
  /// Number of logged subpaths, those without a vertex included.
  [[nodiscard]] double paths() const noexcept { return paths_; }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations.
  template <class Archive>
  void exchange_state(Archive& archive) {
    const std::size_t pixels = sums_.size();
    archive(sums_, squares_, records_, paths_, half_paths_, cost_, half_, seen_);
    sums_.resize(pixels), squares_.resize(pixels);  // where the archive is broken
    half_ = std::min(half_, records_.size());
  }

 private:
  static constexpr double borrowed = 8.0;

  CropPixels crop_;
  std::size_t stride_ = 1;
  std::vector<VertexLog<T>> logs_;  // of the present iteration, by row of the crop
  std::vector<double> sums_, squares_;
  std::vector<VertexRecord<T>> records_;
  double paths_ = 0.0, half_paths_ = 0.0, cost_ = 0.0;
  std::size_t half_ = 0;  // number of records of the first half of the iterations
  std::uint32_t seen_ = 0;
};

}  // namespace gmis
