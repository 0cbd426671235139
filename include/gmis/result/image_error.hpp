#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"

namespace gmis {

/// Added to the squared value that a squared error is divided by, so that dark pixels do not
/// dominate.
inline constexpr double relative_error_floor = 0.01;

/// Number of worst pixels that are left out of a trimmed figure: 0.1 %, rounded down.
[[nodiscard]] constexpr std::size_t trimmed_pixels(std::size_t pixels) noexcept {
  return pixels / 1000;
}

/// Mean over pixels and channels without the worst pixels, from the sum over the channels of each
/// pixel. Orders `per_pixel` anew.
[[nodiscard]] inline double trimmed_mean(std::span<double> per_pixel, std::size_t channels) {
  const std::size_t kept = per_pixel.size() - trimmed_pixels(per_pixel.size());
  if (kept == 0 || channels == 0) return 0.0;
  // NaN has no place in an order: it counts as the worst.
  double* const begin = per_pixel.data();
  double* const end = std::partition(begin, begin + per_pixel.size(), [](double value) { return !std::isnan(value); });
  if (begin + kept < end) std::nth_element(begin, begin + (kept - 1), end);
  double sum = 0.0;
  for (const double value : per_pixel.first(kept)) sum += value;
  return sum / static_cast<double>(kept * channels);
}

/// How far an image is from a reference.
struct ImageError {
  double relmse = 0.0;          ///< mean over pixels and channels of (x − ref)² / (ref² + 0.01)
  double relmse_trimmed = 0.0;  ///< the same without `trimmed_pixels`
  double rmse = 0.0;            ///< √(mean over pixels and channels of (x − ref)²)
};

/// Compares two images of the same size, given as `channels` numbers per pixel. A value that is not
/// finite in either makes relmse and rmse so too. Empty images have no error. Throws
/// std::invalid_argument where the sizes differ.
template <class T, class U>
[[nodiscard]] ImageError image_error(std::span<const T> image, std::span<const U> reference, std::size_t channels) {
  require_argument(image.size() == reference.size(), "the reference must have the pixels and channels of the image");
  const std::size_t pixels = channels == 0 ? 0 : image.size() / channels;
  if (pixels == 0) return {};
  std::vector<double> relative(pixels, 0.0);
  double squares = 0.0;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (std::size_t c = 0; c < channels; ++c) {
      const double wanted = static_cast<double>(reference[pixel * channels + c]);
      const double difference = static_cast<double>(image[pixel * channels + c]) - wanted;
      squares += difference * difference;
      relative[pixel] += difference * difference / (wanted * wanted + relative_error_floor);
    }

  ImageError error;
  const double count = static_cast<double>(pixels * channels);
  for (const double value : relative) error.relmse += value;
  error.relmse /= count;
  error.rmse = std::sqrt(squares / count);
  error.relmse_trimmed = trimmed_mean(relative, channels);
  return error;
}

}  // namespace gmis
