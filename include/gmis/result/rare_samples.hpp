#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <glm/vec2.hpp>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/executor_ref.hpp"
#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"
#include "gmis/result/run_parts.hpp"

/// \file
/// The value that a bright, rare sample (a firefly) is compared with: not the mean of its pixel,
/// which has most likely missed the light of such samples, but a mean around it, from the other
/// parts of the run.

namespace gmis::detail {

/// How far squares around a pixel reach, in pixels beside it.
inline constexpr std::array<int, 5> neighbourhood_reaches{1, 2, 4, 8, 16};

/// A mean around a pixel, and the square that it was taken over.
struct Neighbourhood {
  double mean = 0.0;
  std::size_t reach = 0;  ///< index into `neighbourhood_reaches`
};

/// The mean around a pixel without one part of the run, by a tent, cut at the borders of the image:
/// the smallest one, from 3 to 33 pixels wide, whose square holds `enough_light` times what the
/// part adds to the pixel. In less light than that it is chance whether samples of the same kind
/// have been met around; further away the picture is another one.
template <Spectrum S>
[[nodiscard]] Neighbourhood neighbourhood_without(const RunParts<S>& parts, std::span<const double> mean,
                                                  std::size_t index, std::size_t part) {
  constexpr double enough_light = 2.5;
  constexpr std::size_t channels = BatchMeans<S>::channel_count;
  const glm::ivec2 resolution = parts.resolution();
  const int pixel = static_cast<int>(index / channels), x = pixel % resolution.x, y = pixel / resolution.x;
  const double share = parts.share(part), added = share * parts.value(part, index);
  Neighbourhood around;
  for (;; ++around.reach) {
    const int reach = neighbourhood_reaches[around.reach];
    double light = 0.0, sum = 0.0, weights = 0.0;
    for (int v = std::max(0, y - reach); v <= std::min(resolution.y - 1, y + reach); ++v)
      for (int u = std::max(0, x - reach); u <= std::min(resolution.x - 1, x + reach); ++u) {
        const auto there = static_cast<std::size_t>(v * resolution.x + u) * channels + index % channels;
        const double weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
        const double value = (mean[there] - share * parts.value(part, there)) / (1.0 - share);
        light += value;
        sum += weight * value;
        weights += weight;
      }
    around.mean = sum / weights;
    if (light >= enough_light * added || around.reach + 1 == neighbourhood_reaches.size()) return around;
  }
}

/// A part of a run that lies far off the others in one value (`PartsOfValues::is_rare`).
struct RareSample {
  std::size_t index = 0;   ///< of the value
  std::size_t part = 0;    ///< of the run
  Neighbourhood around{};  ///< without the part
};

/// The rare samples of a run, by value and part, each with the mean around it.
///
/// Rare samples fall where their light is: in the bright places of a neighbourhood, which are
/// brighter than its mean. How much brighter, the other parts tell at the very same pixels; by few
/// samples of their own in each pixel, but without bias, so all pixels with squares of the same
/// size tell it together: Σ ω (mean of the others there) / Σ ω (mean around), with ω the share of
/// the sample in the squared relative error. The excess of this quotient over 1 is multiplied by n
/// / (n + 20), n = (Σ y)² / Σ y² the effective number of the terms y of the upper sum (20 by
/// calibration).
class RareSamples {
 public:
  /// `samples`: by value and part, without what is around them. `mean`: of every value of the
  /// picture.
  template <Spectrum S>
  RareSamples(const RunParts<S>& parts, std::span<const double> mean, std::vector<RareSample> samples,
              ExecutorRef executor)
      : samples_(std::move(samples)) {
    constexpr std::size_t at_once = 64;
    executor.parallel_for_all((samples_.size() + at_once - 1) / at_once, [&](std::size_t block) {
      const std::size_t end = std::min(samples_.size(), (block + 1) * at_once);
      for (std::size_t k = block * at_once; k < end; ++k)
        samples_[k].around = neighbourhood_without(parts, mean, samples_[k].index, samples_[k].part);
    });
    std::array<double, neighbourhood_reaches.size()> there{}, around{}, squares{};
    for (const RareSample& sample : samples_) {
      const double deviation = parts.value(sample.part, sample.index) - mean[sample.index];
      const double others = parts.mean_of_others(sample.part, mean[sample.index], deviation);
      const double share =
          parts.variance_by(sample.part, deviation) / (square(sample.around.mean) + relative_error_floor);
      there[sample.around.reach] += share * others;
      squares[sample.around.reach] += square(share * others);
      around[sample.around.reach] += share * sample.around.mean;
    }
    for (std::size_t r = 0; r < brightness_.size(); ++r) {
      constexpr double trusted_after = 20.0;
      if (!(there[r] > around[r] && around[r] > 0.0)) continue;
      const double effective = square(there[r]) / squares[r];
      brightness_[r] += (there[r] / around[r] - 1.0) * effective / (effective + trusted_after);
    }
  }

  /// The rare samples, by value and part.
  [[nodiscard]] std::span<const RareSample> samples() const noexcept { return samples_; }
  /// The value that the sample is compared with.
  [[nodiscard]] double value_at(const RareSample& sample) const noexcept {
    return brightness_[sample.around.reach] * sample.around.mean;
  }

 private:
  std::vector<RareSample> samples_;
  std::array<double, neighbourhood_reaches.size()> brightness_{1.0, 1.0, 1.0, 1.0,
                                                               1.0};  ///< over the mean around, by reach
};

}  // namespace gmis::detail
