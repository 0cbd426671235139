#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

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

/// The rows above and below some rows of a picture: all that a neighbourhood of those may reach.
struct RowsAround {
  int above = 0;                                 ///< number of the rows above
  int below = 0;                                 ///< number of the rows below
  std::vector<std::vector<double>> part_values;  ///< by part of the run; first the rows above
  std::vector<double> mean{};                    ///< of all parts
};

/// The mean around a pixel without one part of the run, by a tent, cut at the borders of the image:
/// the smallest one, from 3 to 33 pixels wide, whose square holds `enough_light` times what the
/// part adds to the pixel. With less light the square may contain no comparable samples; a larger
/// one covers other parts of the picture. `mean`: of all parts.
template <Spectrum S>
[[nodiscard]] Neighbourhood neighbourhood_without(const RunParts<S>& parts, std::span<const double> mean,
                                                  const RowsAround& rows_around, std::size_t index, std::size_t part) {
  constexpr double enough_light = 2.5;
  constexpr std::size_t channels = BatchMeans<S>::channel_count;
  const glm::ivec2 resolution = parts.resolution();
  const int pixel = static_cast<int>(index / channels), x = pixel % resolution.x, y = pixel / resolution.x;
  const double share = parts.share(part), added = share * parts.value(part, index);
  Neighbourhood around;
  for (;; ++around.reach) {
    const int reach = neighbourhood_reaches[around.reach];
    const int first = std::max(-rows_around.above, y - reach);
    const int last = std::min(resolution.y - 1 + rows_around.below, y + reach);
    double light = 0.0, sum = 0.0, weights = 0.0;
    for (int v = first; v <= last; ++v) {
      const bool is_here = v >= 0 && v < resolution.y;
      const int row = is_here ? v : rows_around.above + (v < 0 ? v : v - resolution.y);
      const std::vector<double>* const elsewhere = is_here ? nullptr : &rows_around.part_values[part];
      for (int u = std::max(0, x - reach); u <= std::min(resolution.x - 1, x + reach); ++u) {
        const auto there = static_cast<std::size_t>(row * resolution.x + u) * channels + index % channels;
        const double weight = (reach + 1 - std::abs(u - x)) * (reach + 1 - std::abs(v - y));
        const double of_part = is_here ? parts.value(part, there) : (*elsewhere)[there];
        const double value = ((is_here ? mean : rows_around.mean)[there] - share * of_part) / (1.0 - share);
        light += value;
        sum += weight * value;
        weights += weight;
      }
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

/// Sums over rare samples, by the reach of their neighbourhoods, which tell how much brighter their
/// places are than the means around.
///
/// Rare samples fall where their light is: in the bright places of a neighbourhood, which are
/// brighter than its mean. The other parts show at the same pixels how much brighter: from few
/// samples in each pixel, but without bias, so that the sums run over all pixels with squares of
/// the same size: Σ ω (mean of the others there) / Σ ω (mean around), with ω the share of the
/// sample in the squared relative error. The excess of this quotient over 1 is multiplied by n /
/// (n + 20), n = (Σ y)² / Σ y² the effective number of the terms y of the upper sum (20 by
/// calibration).
struct BrightnessSums {
  using Numbers = std::array<double, neighbourhood_reaches.size()>;

  Numbers there{};    ///< Σ y, y = ω (mean of the others there)
  Numbers squares{};  ///< Σ y²
  Numbers around{};   ///< Σ ω (mean around)

  /// Adds a sample. `mean`: of all parts of the run, there.
  template <Spectrum S>
  void add(const RunParts<S>& parts, double mean, const RareSample& sample) {
    const double deviation = parts.value(sample.part, sample.index) - mean;
    const double others = parts.mean_of_others(sample.part, mean, deviation);
    const double share =
        parts.variance_by(sample.part, deviation) / (square(sample.around.mean) + relative_error_floor);
    there[sample.around.reach] += share * others;
    squares[sample.around.reach] += square(share * others);
    around[sample.around.reach] += share * sample.around.mean;
  }
  BrightnessSums& operator+=(const BrightnessSums& other) noexcept {
    for (std::size_t r = 0; r < there.size(); ++r) {
      there[r] += other.there[r];
      squares[r] += other.squares[r];
      around[r] += other.around[r];
    }
    return *this;
  }

  /// The value that a rare sample is compared with over the mean around it, by reach.
  [[nodiscard]] Numbers brightness() const noexcept {
    Numbers brightness;
    brightness.fill(1.0);
    for (std::size_t r = 0; r < brightness.size(); ++r) {
      constexpr double trusted_after = 20.0;
      if (!(there[r] > around[r] && around[r] > 0.0)) continue;
      const double effective = square(there[r]) / squares[r];
      brightness[r] += (there[r] / around[r] - 1.0) * effective / (effective + trusted_after);
    }
    return brightness;
  }
};

}  // namespace gmis::detail
