#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/math.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/transport/pixel_counts/crop_pixels.hpp"
#include "gmis/transport/pixel_counts/pixel_counts.hpp"

namespace gmis {

/// Variance and cost of one iteration, per pixel. The variance is relative to the squared value of
/// the pixel, as in relMSE.
struct IterationFigures {
  double variance = 0.0;  ///< mean over the pixels, without the worst 0.1 %
  double cost = 0.0;      ///< unit: `OperationCosts`

  friend constexpr IterationFigures operator+(const IterationFigures& a, const IterationFigures& b) noexcept {
    return {a.variance + b.variance, a.cost + b.cost};
  }
};

/// Learns a `PixelCountTable` from the first iterations of a run. These have two subpaths a pixel,
/// and are part of the picture as usual. What the two differ by is the variance that more subpaths
/// divide. All other variance stays: that of splats, and what both share of one set of photons. The
/// same bits for any number of threads.
class PixelCountLearner {
 public:
  static constexpr std::uint32_t iterations = 4;  ///< that it learns from
  static constexpr std::uint32_t subpaths = 2;    ///< camera subpaths of a pixel in these iterations
  /// A table is used when it is predicted to make variance × cost at most this times as large.
  static constexpr double most_work = 0.9;

  PixelCountLearner() = default;
  /// Learns the numbers for the pixels of `crop`.
  explicit PixelCountLearner(const CropPixels& crop) : crop_(crop), pixels_(crop.frame_size()) {}

  /// Iterations so far.
  [[nodiscard]] std::uint32_t seen() const noexcept { return seen_; }

  /// Notes the subpaths of a pixel in the present iteration: the difference of their values, each
  /// with weight one, as a mean over channels, and the cost of both. Different pixels may be noted
  /// at the same time.
  void note(std::size_t pixel, double difference, double cost) noexcept {
    Figures& figures = pixels_[pixel];
    figures.own[seen_ / half_length] += square(difference) / 2.0;
    figures.apart[seen_ / half_length] += std::abs(difference);
    figures.cost += cost / subpaths;
  }

  /// Ends an iteration with this picture; `cost` is that of all its work.
  template <Spectrum S>
  void end_iteration(std::span<const S> frame, double cost) {
    const std::size_t half = seen_ / half_length;
    for (std::size_t pixel = 0; pixel < frame.size(); ++pixel) {
      const auto value = static_cast<double>(mean_channel(frame[pixel]));
      pixels_[pixel].sum[half] += value;
      pixels_[pixel].squares[half] += square(value);
    }
    cost_ += cost;
    ++seen_;
  }

  /// The table, after `iterations`; nothing when it would gain little. λ is the best of five
  /// values: the one with the least variance × cost, as each half of the iterations predicts it for
  /// a table from the other half.
  GMIS_RARE [[nodiscard]] std::optional<PixelCountTable> table() const {
    const std::vector<double> scales =
        crop_.scales<double>([&](std::size_t p) { return (pixels_[p].sum[0] + pixels_[p].sum[1]) / iterations; });
    const std::vector<double> costs = crop_.blurred([&](std::size_t p) { return pixels_[p].cost / iterations; });
    // For normal values the mean of |x − y| is 2 √(V/π). It is less than a mean of squares in the
    // hands of a few large values, after which a subpath more is not wanted.
    const auto own_of = [&](std::array<double, 2> shares) {
      std::vector<double> own = crop_.blurred([&](std::size_t p) {
        return (shares[0] * pixels_[p].apart[0] + shares[1] * pixels_[p].apart[1]) / half_length;
      });
      crop_.for_each([&](std::size_t p) { own[p] = 0.25 * pi<double> * square(scales[p] * own[p]); });
      return own;
    };
    const std::array halves{own_of({1.0, 0.0}), own_of({0.0, 1.0})};
    // Cost beside that of camera subpaths, of the whole picture.
    double fixed = cost_ / iterations;
    crop_.for_each([&](std::size_t p) { fixed -= subpaths * pixels_[p].cost / iterations; });
    const auto ones = [](std::size_t) { return 1U; };
    const IterationFigures plain =
        predicted(0, scales, std::max(0.0, fixed), ones) + predicted(1, scales, std::max(0.0, fixed), ones);
    if (!(plain.variance > 0.0) || !(plain.cost > 0.0)) return std::nullopt;
    const double lambda = std::sqrt(plain.cost / plain.variance);
    double best = most_work, chosen = 0.0;
    for (const double factor : {0.5, 0.7, 1.0, 1.4, 2.0}) {
      IterationFigures made;
      for (const std::size_t half : {0U, 1U})
        made = made + predicted(1 - half, scales, std::max(0.0, fixed),
                                [&](std::size_t p) { return count(factor * lambda, halves[half][p], costs[p]); });
      const double work = made.variance * made.cost / (plain.variance * plain.cost);
      if (work < best) best = work, chosen = factor * lambda;
    }
    if (chosen == 0.0) return std::nullopt;
    const std::vector<double> own = own_of({0.5, 0.5});
    std::vector<std::uint8_t> counts(pixels_.size(), 1);
    crop_.for_each([&](std::size_t p) { counts[p] = static_cast<std::uint8_t>(count(chosen, own[p], costs[p])); });
    return PixelCountTable(std::move(counts));
  }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations.
  template <class Archive>
  void exchange_state(Archive& archive) {
    const std::size_t size = pixels_.size();
    archive(pixels_, cost_, seen_);
    pixels_.resize(size);  // where the archive is broken
    seen_ = std::min(seen_, iterations - 1);
  }

 private:
  static constexpr std::uint32_t half_length = iterations / 2;

  /// Figures of one pixel, by half of the iterations.
  struct Figures {
    std::array<double, 2>
        own{};  ///< sum of the variance of one subpath that another one in the same iteration does not share
    std::array<double, 2> apart{};    ///< of how far two of them are apart
    std::array<double, 2> sum{};      ///< of the values of the frame
    std::array<double, 2> squares{};  ///< of their squares
    double cost = 0.0;                ///< sum of the cost of one subpath
  };

  /// The number n of least variance × cost, for a relative variance V of one subpath and its cost
  /// C: λ √(V/C), rounded so that V/n + C n / λ² is least, in [1, most].
  [[nodiscard]] static std::uint32_t count(double lambda, double variance, double cost) noexcept {
    constexpr double least_cost = 0.5;
    const double squared = square(lambda) * variance / std::max(least_cost, cost);
    std::uint32_t n = 1;
    while (n < PixelCountTable::most && squared > static_cast<double>(n) * (n + 1)) ++n;
    return n;
  }

  /// Relative variance of an iteration, without the worst pixels, and its cost, if the pixel p had
  /// `count_of(p)` subpaths, as one half of the iterations has it.
  template <class CountOf>
  [[nodiscard]] IterationFigures predicted(std::size_t half, const std::vector<double>& scales, double fixed,
                                           CountOf&& count_of) const {
    constexpr double n = half_length;
    std::vector<double> variances;
    double cost = fixed;
    crop_.for_each([&](std::size_t p) {
      const Figures& of = pixels_[p];
      const double all = (of.squares[half] - square(of.sum[half]) / n) / (n - 1.0), own = of.own[half] / n;
      const double count = count_of(p);
      variances.push_back(square(scales[p]) * (all + own * (1.0 / count - 1.0 / subpaths)));
      cost += count * of.cost / iterations;
    });
    return {trimmed_mean(variances, 1), cost / static_cast<double>(std::max<std::size_t>(1, crop_.size()))};
  }

  CropPixels crop_;
  std::vector<Figures> pixels_;
  double cost_ = 0.0;
  std::uint32_t seen_ = 0;
};

}  // namespace gmis
