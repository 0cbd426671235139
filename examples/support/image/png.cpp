#include <algorithm>
#include <cmath>
#include <fstream>

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

std::vector<std::uint8_t> png_of(const Image& image, float exposure) {
  std::vector<std::uint8_t> pixels(image.rgb.size());
  std::transform(image.rgb.begin(), image.rgb.end(), pixels.begin(), [&](float x) { return to_srgb(exposure * x); });
  png_image description{};
  description.version = PNG_IMAGE_VERSION;
  description.width = static_cast<png_uint_32>(image.width);
  description.height = static_cast<png_uint_32>(image.height);
  description.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(description);
  std::vector<std::uint8_t> file(size);
  if (png_image_write_to_memory(&description, file.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    throw OutputError(std::string("an image cannot be made into a .png: ") + description.message);
  file.resize(size);
  return file;
}

void write_png(const Image& image, const std::filesystem::path& file, float exposure) {
  const std::vector<std::uint8_t> bytes = png_of(image, exposure);
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream.flush())
    throw OutputError(file.string() + ": this file cannot be written: is there such a folder, and space?");
}

#else

bool has_png() {
  return false;
}

std::vector<std::uint8_t> png_of(const Image&, float) {
  throw InputError("this program was built without libpng: it makes no .png");
}

void write_png(const Image&, const std::filesystem::path& file, float) {
  throw InputError(file.string() + ": this program was built without libpng: use .pfm");
}

#endif

}  // namespace gmis::tools
