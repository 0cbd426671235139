#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/image_error.hpp"

namespace gmis {

/// The pixels of a crop in a frame whose pixels are stored by rows.
struct CropPixels {
  std::size_t frame_width = 1;   ///< columns of the frame
  std::size_t frame_height = 1;  ///< rows of the frame
  std::size_t first = 0;         ///< index in the frame of the crop's upper left pixel
  std::size_t width = 0;         ///< columns of the crop
  std::size_t height = 0;        ///< rows of the crop

  /// Number of pixels of the frame.
  [[nodiscard]] std::size_t frame_size() const noexcept { return frame_width * frame_height; }
  /// Number of pixels of the crop.
  [[nodiscard]] std::size_t size() const noexcept { return width * height; }
  /// Index in the frame.
  [[nodiscard]] std::size_t place(std::size_t x, std::size_t y) const noexcept { return first + y * frame_width + x; }

  /// Calls `visit(index in the frame)` for every pixel, row by row.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) visit(place(x, y));
  }

  /// Mean of `value(index in the frame)` over the 5 × 5 pixels around each pixel that lie in the
  /// crop, by index in the frame; 0 beyond the crop.
  template <class Value>
  [[nodiscard]] std::vector<double> blurred(Value&& value) const {
    constexpr std::size_t reach = 2;
    std::vector<double> means(frame_size(), 0.0);
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        double sum = 0.0, count = 0.0;
        for (std::size_t v = y - std::min(y, reach); v < std::min(height, y + reach + 1); ++v)
          for (std::size_t u = x - std::min(x, reach); u < std::min(width, x + reach + 1); ++u) {
            sum += value(place(u, v));
            count += 1.0;
          }
        means[place(x, y)] = sum / count;
      }
    return means;
  }

  /// W of every pixel, by which errors become relative: 1/√(value² + 0.01), the value being
  /// blurred; 1 beyond the crop.
  template <std::floating_point T, class Value>
  [[nodiscard]] std::vector<T> scales(Value&& value) const {
    std::vector<T> result(frame_size(), T(1));
    const std::vector<double> means = blurred(value);
    for_each([&](std::size_t pixel) {
      result[pixel] = static_cast<T>(1.0 / std::sqrt(square(means[pixel]) + relative_error_floor));
    });
    return result;
  }
};

}  // namespace gmis
