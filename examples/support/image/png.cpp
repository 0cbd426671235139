#include <algorithm>
#include <array>
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

/// The three values of a pixel, brought down by the curve.
std::array<float, 3> toned(const float* rgb, float exposure, ToneCurve tone) {
  std::array<float, 3> x{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float value = exposure * rgb[c];
    x[c] = value > 0 ? std::min(value, 1e15F) : 0;  // so that squares stay finite
  }
  if (tone == ToneCurve::reinhard) {
    const float luminance = 0.2126F * x[0] + 0.7152F * x[1] + 0.0722F * x[2];
    for (float& value : x) value /= 1 + luminance;
  } else if (tone == ToneCurve::filmic) {
    for (float& value : x) value = value * (2.51F * value + 0.03F) / (value * (2.43F * value + 0.59F) + 0.14F);
  }
  return x;
}

/// Adds a chunk of type iTXt: length, type, content, and the CRC-32 of type and content, numbers
/// big-endian [PNG, 5.3].
void append_chunk(std::vector<std::uint8_t>& file, std::string content) {
  const auto append_number = [&](std::uint32_t number) {
    for (const int shift : {24, 16, 8, 0}) file.push_back(static_cast<std::uint8_t>(number >> shift));
  };
  append_number(static_cast<std::uint32_t>(content.size()));
  content.insert(0, "iTXt");
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char letter : content) {
    file.push_back(static_cast<std::uint8_t>(letter));
    crc ^= static_cast<std::uint8_t>(letter);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  append_number(~crc);
}

}  // namespace

std::vector<std::uint8_t> png_of(const Image& image, float exposure, ToneCurve tone) {
  std::vector<std::uint8_t> pixels(image.rgb.size());
  for (std::size_t i = 0; i + 2 < pixels.size(); i += 3) {
    const std::array<float, 3> values = toned(image.rgb.data() + i, exposure, tone);
    std::transform(values.begin(), values.end(), pixels.begin() + static_cast<std::ptrdiff_t>(i), to_srgb);
  }
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

void write_png(const Image& image, const std::filesystem::path& file, const ImageExtras& extras) {
  std::vector<std::uint8_t> bytes = png_of(image, extras.exposure, extras.tone);
  std::vector<std::uint8_t> notes;
  for (const auto& [name, text] : extras.notes)  // after the keyword: not compressed, no language, no translation
    append_chunk(notes, name + std::string(5, '\0') + text);
  constexpr std::ptrdiff_t after_header = 8 + 25;  // the signature and the chunk IHDR
  bytes.insert(bytes.begin() + after_header, notes.begin(), notes.end());
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream.flush())
    throw OutputError(file.string() + ": this file cannot be written: check that the folder exists and has space");
}

#else

bool has_png() {
  return false;
}

std::vector<std::uint8_t> png_of(const Image&, float, ToneCurve) {
  throw InputError("this program was built without libpng: it makes no .png");
}

void write_png(const Image&, const std::filesystem::path& file, const ImageExtras&) {
  throw InputError(file.string() + ": this program was built without libpng: use .pfm");
}

#endif

}  // namespace gmis::tools
