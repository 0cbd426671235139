#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gmis::tools {

class LoadBudget;

/// Linear RGB, three floats per pixel, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgb(3 * static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 0.0F) {}

  [[nodiscard]] std::size_t index(int x, int y) const {
    return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

/// The part of `image` with x0 ≤ x < x1 and y0 ≤ y < y1.
[[nodiscard]] Image cropped(const Image& image, int x0, int y0, int x1, int y1);

/// The means over blocks of `factor` × `factor` pixels; `factor` divides width and height.
[[nodiscard]] Image reduced(const Image& image, int factor);

/// The mean of all pixels and channels.
[[nodiscard]] double mean_of(const Image& image);

/// The exposure, in powers of two from −10 to 10, that brings the log-average of the luminance of
/// all pixels that are not black to 0.25 (Reinhard et al. 2002, eq. 1); 0 for a black picture.
[[nodiscard]] double automatic_exposure(const Image& image);

/// A 64-bit digest of size and bits of every float (FNV-1a), as 16 hexadecimal digits.
[[nodiscard]] std::string image_hash(const Image& image);

/// The curve from linear values x ≥ 0 to the values from 0 to 1 that sRGB then codes, channel by
/// channel but for Reinhard's.
enum class ToneCurve {
  clamp,     ///< min(x, 1)
  reinhard,  ///< x / (1 + Y), Y the luminance of the pixel [Reinhard et al. 2002, eq. 3], and then min(·, 1)
  filmic     ///< x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), Narkowicz's fit (2016) of the ACES curve, cut to 1
};

/// A picture of the same size as the main one, in the same file; `channels` is RGB, XYZ or Z (the
/// first of three).
struct ImageLayer {
  std::string name, channels;
  Image image;
};

/// The content of a picture's file beside the picture, and how the picture is written.
struct ImageExtras {
  float exposure = 1;                                        ///< factor on all values; of .png alone
  ToneCurve tone = ToneCurve::clamp;                         ///< after the exposure; of .png alone
  std::vector<std::pair<std::string, std::string>> notes{};  ///< names and texts; of .exr and .png
  std::vector<ImageLayer> layers{};                          ///< of .exr alone
};

/// Picks the format by the ending of the name. These throw `InputError` when it is not known or not
/// in this build or when the file cannot be read or is no regular file, and `OutputError` when it
/// cannot be written. A file that is there already stays as it is until the new one is whole.
void write_image(const Image& image, const std::filesystem::path& file, const ImageExtras& extras = {});
/// With a `budget`, the pixels are counted before there is memory for them. `alpha` becomes that of
/// the pixels of an .exr with the channels R, G, B and A, and else stays as it is.
[[nodiscard]] Image read_image(const std::filesystem::path& file, LoadBudget* budget = nullptr,
                               std::vector<float>* alpha = nullptr);
/// Throws what `write_image` would throw because of the ending: to be called before the work.
void require_writable_format(const std::filesystem::path& file);

}  // namespace gmis::tools
