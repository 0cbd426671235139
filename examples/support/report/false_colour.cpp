#include "support/report/false_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gmis::tools {

namespace {

/// sRGB, 0 to 255, evenly spaced; each lighter than the one before.
constexpr std::array<std::array<float, 3>, 7> ramp{
    {{0, 0, 4}, {51, 10, 95}, {121, 28, 109}, {187, 55, 84}, {237, 105, 37}, {252, 181, 25}, {252, 255, 164}}};

float linear_of(float srgb) {
  const float x = srgb / 255;
  return x <= 0.04045F ? x / 12.92F : std::pow((x + 0.055F) / 1.055F, 2.4F);
}

}  // namespace

Image pixel_error(const Image& image, const Image& reference) {
  Image error(image.width, image.height);
  for (std::size_t i = 0; i < error.rgb.size(); ++i)
    error.rgb[i] = std::abs(image.rgb[i] - reference.rgb[i]) / std::sqrt(reference.rgb[i] * reference.rgb[i] + 0.01F);
  return error;
}

Image error_map(const Image& pixel_error) {
  Image map(pixel_error.width, pixel_error.height);
  for (std::size_t pixel = 0; 3 * pixel < map.rgb.size(); ++pixel) {
    double square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double error = static_cast<double>(pixel_error.rgb[3 * pixel + c]);
      square += error * error / 3;
    }
    const double decades = std::isfinite(square) ? 0.5 * std::log10(std::max(square, 1e-12)) : 0.0;
    const double place = std::clamp((decades + 2) / 2, 0.0, 1.0) * (ramp.size() - 1);
    const auto step = std::min(static_cast<std::size_t>(place), ramp.size() - 2);
    const auto share = static_cast<float>(place - static_cast<double>(step));
    for (std::size_t c = 0; c < 3; ++c)
      map.rgb[3 * pixel + c] = linear_of(ramp[step][c] + share * (ramp[step + 1][c] - ramp[step][c]));
  }
  return map;
}

float exposure_of(const Image& reference) {
  std::vector<float> brightness;
  for (std::size_t i = 0; i < reference.rgb.size(); i += 3)
    brightness.push_back(std::max({reference.rgb[i], reference.rgb[i + 1], reference.rgb[i + 2]}));
  if (brightness.empty()) return 1;
  const auto place =
      brightness.begin() + static_cast<std::ptrdiff_t>(0.96 * static_cast<double>(brightness.size() - 1));
  std::nth_element(brightness.begin(), place, brightness.end());
  return *place > 0 ? 1 / *place : 1;
}

}  // namespace gmis::tools
