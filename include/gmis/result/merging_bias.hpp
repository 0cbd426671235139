#pragma once

#include <cmath>
#include <cstddef>

#include "gmis/result/film.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis {

/// What merging with a radius above zero adds to an image or takes from it, as a relative error.
struct MergingBias {
  double relative_bias =
      0.0;  ///< √(mean over pixels and channels of bias² / (value² + `relative_error_floor`)), 0 when noise hides it
  double standard_error = 0.0;  ///< of the square above, rooted: a bias below about twice this cannot be told from none
};

/// The bias of merging from two radii. `difference` is a film of (frame with radius `ratio` · r − frame with radius r), iteration
/// by iteration with the same random numbers, so that most of the noise cancels; `value` is the film with radius r. The bias of
/// a density estimate over a disk grows with the square of its radius, so the difference is (ratio² − 1) times the bias
/// at r [Hachisuka et al. 2010, eq. 6]; the noise that the square of the difference contains is subtracted, as measured.
template <Spectrum S>
[[nodiscard]] MergingBias merging_bias(const Film<S>& difference, const Film<S>& value, double ratio) {
  double square = 0.0, noise = 0.0, variance = 0.0;
  for (std::size_t p = 0; p < difference.pixel_count(); ++p)
    for (int c = 0; c < Film<S>::channel_count; ++c) {
      const double mean = difference.mean(p, c), uncertainty = difference.variance_of_mean(p, c);
      const double weight = 1.0 / (value.mean(p, c) * value.mean(p, c) + relative_error_floor);
      square += mean * mean * weight;
      noise += uncertainty * weight;
      // Of the square of a normal number: 4 μ² σ² + 2 σ⁴.
      variance += (4.0 * mean * mean * uncertainty + 2.0 * uncertainty * uncertainty) * weight * weight;
    }
  const double count = static_cast<double>(difference.pixel_count()) * Film<S>::channel_count;
  const double scale = 1.0 / (ratio * ratio - 1.0);
  return {scale * std::sqrt(std::max(0.0, square - noise) / count), scale * std::sqrt(std::sqrt(variance) / count)};
}

}  // namespace gmis
