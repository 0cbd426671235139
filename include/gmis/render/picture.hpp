#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "gmis/result/film.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/technique.hpp"

namespace gmis {

/// An image as plain numbers: linear values in the unit of radiance, rows from the upper left, the
/// channels of a pixel side by side.
struct Picture {
  glm::ivec2 size{0, 0};      ///< width and height in pixels
  int channels = 0;           ///< `SpectrumTraits<S>::channel_count`
  std::vector<float> values;  ///< rows from the top, channels side by side

  Picture() = default;
  /// A black picture.
  Picture(glm::ivec2 size_in_pixels, int channels_of_a_pixel)
      : size(size_in_pixels),
        channels(channels_of_a_pixel),
        values(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
               static_cast<std::size_t>(channels)) {}

  /// One channel of the pixel in column `x` and row `y`.
  [[nodiscard]] float at(int x, int y, int channel) const noexcept {
    return values[(static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x)) *
                      static_cast<std::size_t>(channels) +
                  static_cast<std::size_t>(channel)];
  }
};

/// A picture of the film's size, with `value_of(pixel, channel)` as its values.
template <Spectrum S, class ValueOf>
[[nodiscard]] Picture picture_with(const Film<S>& film, ValueOf&& value_of) {
  constexpr int channels = Film<S>::channel_count;
  Picture picture(film.resolution(), channels);
  for (std::size_t pixel = 0, i = 0; pixel < film.pixel_count(); ++pixel)
    for (int c = 0; c < channels; ++c, ++i) picture.values[i] = static_cast<float>(value_of(pixel, c));
  return picture;
}

/// The means of a film.
template <Spectrum S>
[[nodiscard]] Picture picture_of(const Film<S>& film) {
  return picture_with(film, [&film](std::size_t pixel, int channel) { return film.mean(pixel, channel); });
}

/// The estimated variances of the means of a film, see `Film::variance_of_mean`.
template <Spectrum S>
[[nodiscard]] Picture variance_picture_of(const Film<S>& film) {
  return picture_with(film, [&film](std::size_t pixel, int channel) { return film.variance_of_mean(pixel, channel); });
}

/// The part of the picture that one technique makes.
struct TechniquePicture {
  TechniqueId id;      ///< whose it is
  Picture weighted;    ///< as it adds to the picture
  Picture unweighted;  ///< as if it were the only technique
};

/// The part of the picture that the paths of one class make.
struct ClassPicture {
  PathClass path_class = PathClass::unclassified;  ///< whose it is
  Picture picture;                                 ///< the mean of the iterations
  std::uint64_t contributions = 0;                 ///< that it was made of
  double cost = 0.0;  ///< share of all counted operations, as `costs_of_classes` attributes them
};

/// The part of the picture whose light comes from one group of lights. A picture under other lights
/// is a sum of such parts, each times the factor on its lights.
struct LightPicture {
  std::uint16_t group = 0;  ///< `light_group` of the scene
  Picture picture;          ///< the mean of the iterations
};

}  // namespace gmis
