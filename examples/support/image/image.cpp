#include "support/image/image.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "support/diagnostics.hpp"
#include "support/file_ending.hpp"
#include "support/image/formats.hpp"
#include "support/whole_file.hpp"

namespace gmis::tools {
namespace {

enum class Format { exr, pfm, png };

/// The format of a file that is to be written or read here; a PNG is only ever written.
Format format_of(const std::filesystem::path& file, bool is_read = false) {
  const std::string ending = ending_of(file);
  if (ending == ".pfm") return Format::pfm;
  if (ending == ".exr") {
    if (!has_exr()) throw InputError(file.string() + ": this program was built without OpenEXR: use .pfm");
    return Format::exr;
  }
  if (ending == ".png") {
    if (!has_png() && !is_read) throw InputError(file.string() + ": this program was built without libpng: use .pfm");
    return Format::png;
  }
  throw InputError(file.string() + ": the ending " + in_quotes(ending) + " is not known: use .exr, .pfm or .png");
}

}  // namespace

Image cropped(const Image& image, int x0, int y0, int x1, int y1) {
  Image result(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y)
    std::copy_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(image.index(x0, y)), 3 * (x1 - x0),
                result.rgb.begin() + static_cast<std::ptrdiff_t>(result.index(0, y - y0)));
  return result;
}

Image reduced(const Image& image, int factor) {
  Image result(image.width / factor, image.height / factor);
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int i = 0; i < factor; ++i)
          for (int j = 0; j < factor; ++j)
            sum += static_cast<double>(image.rgb[image.index(factor * x + j, factor * y + i) + c]);
        result.rgb[result.index(x, y) + c] = static_cast<float>(sum / (factor * factor));
      }
  return result;
}

double mean_of(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) sum += static_cast<double>(value);
  return image.rgb.empty() ? 0 : sum / static_cast<double>(image.rgb.size());
}

double automatic_exposure(const Image& image) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const double luminance = 0.2126 * static_cast<double>(image.rgb[i]) +
                             0.7152 * static_cast<double>(image.rgb[i + 1]) +
                             0.0722 * static_cast<double>(image.rgb[i + 2]);
    if (!(luminance > 1e-12 && luminance < 1e30)) continue;
    sum += std::log2(luminance);
    ++count;
  }
  constexpr double key = -2;  // log2 0.25
  return count == 0 ? 0 : std::clamp(key - sum / static_cast<double>(count), -10.0, 10.0);
}

std::string image_hash(const Image& image) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  const auto mix = [&](std::uint32_t word) {
    for (int byte = 0; byte < 4; ++byte) {
      hash = (hash ^ (word & 0xFFU)) * 0x100000001B3U;
      word >>= 8U;
    }
  };
  mix(static_cast<std::uint32_t>(image.width));
  mix(static_cast<std::uint32_t>(image.height));
  for (const float value : image.rgb) mix(std::bit_cast<std::uint32_t>(value));
  std::string digits(16, '0');
  for (std::size_t i = 16; i-- > 0; hash >>= 4U) digits[i] = "0123456789abcdef"[hash & 0xFU];
  return digits;
}

void require_writable_format(const std::filesystem::path& file) {
  (void)format_of(file);
}

void write_image(const Image& image, const std::filesystem::path& file, const ImageExtras& extras) {
  const Format format = format_of(file);
  write_whole(file, [&](const std::filesystem::path& part) {
    switch (format) {
      case Format::exr:
        return write_exr(image, part, extras);
      case Format::pfm:
        return write_pfm(image, part);
      case Format::png:
        return write_png(image, part, extras);
    }
  });
}

Image read_image(const std::filesystem::path& file, LoadBudget* budget, std::vector<float>* alpha) {
  // A pipe or a device might never end.
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": this is no regular file: name an image");
  if (!std::filesystem::exists(file, error))
    throw InputError(file.string() + ": this image is missing: check its name");
  switch (format_of(file, true)) {
    case Format::exr:
      return read_exr(file, budget, alpha);
    case Format::pfm:
      return read_pfm(file, budget);
    case Format::png:
      break;
  }
  throw InputError(file.string() + ": PNG files are too coarse to compare with: use .exr or .pfm");
}

}  // namespace gmis::tools
