#pragma once

#include <cmath>
#include <cstddef>

#include "gmis/result/film.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis {

/// The bias of merging over a whole image, as a relative error.
struct MergingBias {
  /// √(mean over pixels and channels of bias² / (value² + `relative_error_floor`)); 0 when noise hides it.
  double relative_bias = 0.0;
  /// √(standard error of `relative_bias`²); a bias below about twice this may be noise.
  double standard_error = 0.0;
};

/// Estimates the bias of merging from renderings with two radii.
///
/// `value` is the film with radius r. `difference` is the film of (frame with radius `ratio` · r) − (frame with radius
/// r). Both frames of an iteration use the same random numbers, so that most of the noise cancels. `ratio` must be
/// above 1.
///
/// The bias of a density estimate over a disk is proportional to the square of the radius
/// [Hachisuka et al. 2010, eq. 6]. The expected difference is therefore (ratio² − 1) times the bias at r. The squared
/// difference contains the variance of the mean, which is measured and subtracted.
template <Spectrum S>
[[nodiscard]] MergingBias merging_bias(const Film<S>& difference, const Film<S>& value, double ratio) {
  double square = 0.0, noise = 0.0, variance = 0.0;
  for (std::size_t p = 0; p < difference.pixel_count(); ++p)
    for (int c = 0; c < Film<S>::channel_count; ++c) {
      const double mean = difference.mean(p, c), uncertainty = difference.variance_of_mean(p, c);
      const double weight = 1.0 / (value.mean(p, c) * value.mean(p, c) + relative_error_floor);
      square += mean * mean * weight;
      noise += uncertainty * weight;
      // Variance of the square of a normal variable: 4 μ² σ² + 2 σ⁴.
      variance += (4.0 * mean * mean * uncertainty + 2.0 * uncertainty * uncertainty) * weight * weight;
    }
  const double count = static_cast<double>(difference.pixel_count()) * Film<S>::channel_count;
  const double scale = 1.0 / (ratio * ratio - 1.0);
  return {scale * std::sqrt(std::max(0.0, square - noise) / count), scale * std::sqrt(std::sqrt(variance) / count)};
}

}  // namespace gmis
