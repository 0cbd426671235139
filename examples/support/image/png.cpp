#include <algorithm>
#include <cmath>

#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"

#if GMIS_HAS_PNG
#include <png.h>
#endif

namespace gmis::tools {

#if GMIS_HAS_PNG

bool has_png() {
  return true;
}

namespace {

std::uint8_t to_srgb(float linear) {
  if (!(linear > 0)) return 0;
  const float x = std::min(linear, 1.0F);
  const float curved = x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1 / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lround(255 * curved));
}

}  // namespace

void write_png(const Image& image, const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes(image.rgb.size());
  std::transform(image.rgb.begin(), image.rgb.end(), bytes.begin(), to_srgb);
  png_image description{};
  description.version = PNG_IMAGE_VERSION;
  description.width = static_cast<png_uint_32>(image.width);
  description.height = static_cast<png_uint_32>(image.height);
  description.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&description, file.string().c_str(), 0, bytes.data(), 0, nullptr) == 0)
    throw OutputError(file.string() + ": this file cannot be written: is there such a folder, and space?");
}

#else

bool has_png() {
  return false;
}

void write_png(const Image&, const std::filesystem::path& file) {
  throw InputError(file.string() + ": this program was built without libpng: use .pfm");
}

#endif

}  // namespace gmis::tools
