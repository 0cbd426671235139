#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/result/row_copy.hpp"

namespace gmis {

/// Mean and variance over independent iterations, for every pixel and channel.
///
/// Means are updated in double by Welford's recurrence, which does not drift: a constant stream of
/// 1e9 samples keeps its value to the last bits. Pixels are stored by rows from the upper left.
template <Spectrum S>
class Film {
 public:
  using Scalar = ScalarOf<S>;
  static constexpr int channel_count = SpectrumTraits<S>::channel_count;

  /// A film without iterations.
  explicit Film(glm::ivec2 resolution)
      : resolution_(resolution),
        moments_(static_cast<std::size_t>(resolution.x) * static_cast<std::size_t>(resolution.y) * channel_count) {}

  /// Adds the frame of one iteration, which must be independent of all other iterations. `frame`
  /// has one value per pixel.
  void add_iteration(std::span<const S> frame) {
    ++iterations_;
    const double weight = 1.0 / static_cast<double>(iterations_);
    std::size_t i = 0;
    for (const S& pixel : frame)
      for (int c = 0; c < channel_count; ++c, ++i) {
        Moments& moments = moments_[i];
        const double value = static_cast<double>(SpectrumTraits<S>::channel(pixel, c));
        const double difference = value - moments.mean;
        moments.mean += difference * weight;
        moments.sum_of_squares += difference * (value - moments.mean);
      }
  }

  /// Adds all iterations of a film of the same size that are independent of those here. The means
  /// of both are weighted by their numbers of iterations; squared deviations are taken from the
  /// common mean [Chan, Golub, LeVeque 1979].
  void join(const Film& other) {
    if (other.iterations_ == 0) return;
    const double share = static_cast<double>(other.iterations_) / static_cast<double>(iterations_ + other.iterations_);
    for (std::size_t i = 0; i < moments_.size(); ++i) {
      Moments& moments = moments_[i];
      const double difference = other.moments_[i].mean - moments.mean;
      moments.mean += difference * share;
      moments.sum_of_squares +=
          other.moments_[i].sum_of_squares + difference * difference * share * static_cast<double>(iterations_);
    }
    iterations_ += other.iterations_;
  }

  /// Takes rows over from a film of the same width; all of its pixels have the same iterations.
  void copy_rows(const Film& other, const RowCopy& rows) {
    iterations_ = other.iterations_;
    rows(other.moments_, moments_, static_cast<std::size_t>(resolution_.x) * channel_count);
  }

  /// In pixels.
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return resolution_; }
  /// Iterations that were added.
  [[nodiscard]] std::uint64_t iterations() const noexcept { return iterations_; }
  /// Width times height.
  [[nodiscard]] std::size_t pixel_count() const noexcept { return moments_.size() / channel_count; }

  /// The value of a pixel: the mean of the iterations.
  [[nodiscard]] double mean(std::size_t pixel, int channel) const noexcept { return at(pixel, channel).mean; }

  /// Estimated variance of `mean`: the sample variance of the iterations divided by their number; 0
  /// for fewer than two.
  [[nodiscard]] double variance_of_mean(std::size_t pixel, int channel) const noexcept {
    if (iterations_ < 2) return 0.0;
    const double n = static_cast<double>(iterations_);
    return at(pixel, channel).sum_of_squares / (n * (n - 1.0));
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(iterations_, moments_);
  }

 private:
  struct Moments {
    double mean = 0.0;
    double sum_of_squares = 0.0;  ///< sum of squared deviations from the mean
  };

  [[nodiscard]] const Moments& at(std::size_t pixel, int channel) const noexcept {
    return moments_[pixel * channel_count + static_cast<std::size_t>(channel)];
  }

  glm::ivec2 resolution_;
  std::uint64_t iterations_ = 0;
  std::vector<Moments> moments_;
};

/// Means over all pixels and channels of a film. They do not include a relative error, because its
/// denominator and its variance must come from different iterations (`estimate_error`).
struct ImageEstimate {
  double mean = 0.0;      ///< mean value
  double variance = 0.0;  ///< mean variance of the pixel means
};

/// The estimates of a film, which must have at least one pixel.
template <Spectrum S>
[[nodiscard]] ImageEstimate estimate_of(const Film<S>& film) {
  ImageEstimate result;
  for (std::size_t p = 0; p < film.pixel_count(); ++p)
    for (int c = 0; c < Film<S>::channel_count; ++c) {
      result.mean += film.mean(p, c);
      result.variance += film.variance_of_mean(p, c);
    }
  const double count = static_cast<double>(film.pixel_count()) * Film<S>::channel_count;
  result.mean /= count;
  result.variance /= count;
  return result;
}

}  // namespace gmis
