#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace gmis {

/// Added to the squared value that a squared error is divided by, so that dark pixels do not rule.
inline constexpr double relative_error_floor = 0.01;

/// How far an image is from a reference.
struct ImageError {
  double relmse = 0.0;          ///< mean over pixels and channels of (x − ref)² / (ref² + 0.01)
  double relmse_trimmed = 0.0;  ///< the same without the worst 0.1 % of the pixels (rounded down)
  double rmse = 0.0;            ///< √(mean over pixels and channels of (x − ref)²)
};

/// Compares two images of the same size, given as `channels` numbers per pixel. A value that is not finite in either
/// makes relmse and rmse so too. Empty images have no error.
template <class T, class U>
[[nodiscard]] ImageError image_error(std::span<const T> image, std::span<const U> reference, std::size_t channels) {
  const std::size_t pixels = channels == 0 ? 0 : std::min(image.size(), reference.size()) / channels;
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

  const auto mean_of_first = [&](std::size_t count) {
    double sum = 0.0;
    for (std::size_t pixel = 0; pixel < count; ++pixel) sum += relative[pixel];
    return sum / static_cast<double>(count * channels);
  };
  ImageError error;
  error.relmse = mean_of_first(pixels);
  error.rmse = std::sqrt(squares / static_cast<double>(pixels * channels));
  const std::size_t kept = pixels - pixels / 1000;
  error.relmse_trimmed = error.relmse;
  if (kept == pixels) return error;
  // NaN has no place in an order: it counts as the worst.
  const auto is_better = [](double a, double b) { return std::isnan(b) ? !std::isnan(a) : a < b; };
  std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(kept - 1), relative.end(),
                   is_better);
  error.relmse_trimmed = mean_of_first(kept);
  return error;
}

}  // namespace gmis
