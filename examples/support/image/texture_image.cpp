#include "support/image/texture_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "support/file_ending.hpp"
#include "support/image/image.hpp"
#include "support/read_file.hpp"

#if GMIS_HAS_STB
namespace gmis::tools {
namespace {

/// Size of the largest block that stb_image may allocate, and of one that it was refused, or 0.
thread_local std::size_t stb_largest = 0, stb_refused = 0;

/// A pixel of PNG may unpack to gigabytes. Zeros, because version 2.27 reads tables and pixels that
/// a broken file leaves out.
void* stb_allocate(void* block, std::size_t size) {
  if (size > stb_largest) {
    stb_refused = size;
    return nullptr;
  }
  return block == nullptr ? std::calloc(1, size) : std::realloc(block, size);
}

}  // namespace
}  // namespace gmis::tools

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_TGA
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 32768
#define STBI_MALLOC(size) gmis::tools::stb_allocate(nullptr, size)
#define STBI_REALLOC gmis::tools::stb_allocate
#define STBI_FREE std::free
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#if defined(__clang__)  // its JPEG tables are addressed one past their end
#pragma clang attribute push(__attribute__((no_sanitize("undefined"))), apply_to = function)
#endif
#include <stb/stb_image.h>
#if defined(__clang__)
#pragma clang attribute pop
#endif
#pragma GCC diagnostic pop
#endif

namespace gmis::tools {
namespace {

using Shared = std::shared_ptr<const scene::TextureImage>;

[[maybe_unused]] float decode(double code, const TextureEncoding& encoding) {
  switch (encoding.curve) {
    case TextureEncoding::Curve::linear:
      return static_cast<float>(code);
    case TextureEncoding::Curve::gamma:
      return static_cast<float>(std::pow(code, encoding.gamma));
    case TextureEncoding::Curve::srgb:
      break;
  }
  return static_cast<float>(code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4));
}

/// True where there is an alpha that is not 1 everywhere.
bool is_transparent(const std::vector<float>& alpha) {
  return std::any_of(alpha.begin(), alpha.end(), [](float value) { return value != 1.0F; });
}

Shared from_floats(const Image& image, std::vector<float> alpha, TexturePart part) {
  auto result = std::make_shared<scene::TextureImage>();
  result->resolution = {image.width, image.height};
  if (is_transparent(alpha)) {
    result->channels = 1;
    result->floats = std::move(alpha);
    return result;
  }
  if (part == TexturePart::color) {
    result->floats = image.rgb;
    return result;
  }
  result->channels = 1;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3)
    result->floats.push_back(part == TexturePart::alpha ? 1 : (image.rgb[i] + image.rgb[i + 1] + image.rgb[i + 2]) / 3);
  return result;
}

#if GMIS_HAS_STB

/// More than any of the tables of stb_image takes.
constexpr std::size_t stb_own_memory = std::size_t{1} << 16U;

/// Memory that stb_image has allocated.
template <class Value>
using Pixels = std::unique_ptr<Value, void (*)(void*)>;

/// The colours, or for any other `part` their mean, of `count` pixels with `channels` values each;
/// `linear` converts one value to a linear one.
template <class Value, class Linear>
std::vector<float> picked(const Value* pixels, std::size_t count, int channels, TexturePart part,
                          const Linear& linear) {
  std::vector<float> result;
  const int colors = channels < 3 ? 1 : 3;
  for (std::size_t i = 0; i < count; ++i) {
    const Value* pixel = pixels + i * static_cast<std::size_t>(channels);
    if (part == TexturePart::color) {
      for (int c = 0; c < colors; ++c) result.push_back(linear(pixel[c]));
    } else {
      float sum = 0;
      for (int c = 0; c < colors; ++c) sum += linear(pixel[c]);
      result.push_back(sum / static_cast<float>(colors));
    }
  }
  return result;
}

constexpr std::array<unsigned char, 8> png_signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

bool is_png(const unsigned char* bytes, std::size_t count) {
  return count >= png_signature.size() && std::equal(png_signature.begin(), png_signature.end(), bytes);
}

/// True for a PNG with a chunk that says it is longer than the rest of the file: stb_image would
/// ask for the memory before it reads.
bool has_chunk_beyond_end(const unsigned char* bytes, std::size_t count) {
  if (!is_png(bytes, count)) return false;
  for (std::size_t at = png_signature.size(); at + 8 <= count;) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = 256 * length + bytes[at + i];
    if (length > count - at - 8) return true;
    at += 12 + length;
  }
  return false;
}

/// True for a PNG whose pixels are red, green, blue and alpha.
bool is_rgba_png(const unsigned char* bytes, std::size_t count) {
  constexpr std::size_t place_of_type = 25, rgba = 6;  // in the header, the first chunk
  return is_png(bytes, count) && count > place_of_type && bytes[place_of_type] == rgba;
}

/// True for a JPEG with a Huffman table of more than 256 symbols: stb_image 2.27 writes them beyond
/// its table. Segments are found as stb_image finds them.
bool has_long_huffman_table(const unsigned char* bytes, std::size_t count) {
  if (count < 2 || bytes[0] != 0xff) return false;
  const auto byte = [&](std::size_t at) { return at < count ? bytes[at] : 0U; };
  for (std::size_t at = 0; at < count;) {
    if (bytes[at++] != 0xff) continue;
    while (byte(at) == 0xff) ++at;
    const unsigned marker = byte(at++);
    if (marker == 0xd9) return false;
    if (marker == 0 || (marker >= 0xd0 && marker <= 0xd8)) continue;  // a byte of pixels; has no length
    const std::size_t end = at + 256 * byte(at) + byte(at + 1);
    if (marker == 0xc4)
      for (std::size_t table = at + 2; table < end;) {
        std::size_t symbols = 0;
        for (std::size_t i = 1; i <= 16; ++i) symbols += byte(table + i);
        if (symbols > 256) return true;
        table += 17 + symbols;
      }
    at = end;
  }
  return false;
}

}  // namespace

Shared read_texture_image(const unsigned char* bytes, std::size_t count, const std::string& name,
                          const TextureEncoding& encoding, TexturePart part, LoadBudget& budget,
                          const SourcePosition& where) {
  const auto fail = [&]() -> InputError {
    if (stb_refused > 0) budget.take(stb_refused, "the image " + file_in_quotes(name), where);
    const char* given = stbi_failure_reason();
    const std::string reason = given == nullptr ? "" : given;
    const std::string known = "unknown image type";
    return {where, "the image " + file_in_quotes(name) + " cannot be read: " +
                       (reason == known ? "it is of no kind that is known: use .png, .tga, .jpg, .bmp or .hdr"
                                        : "the file is damaged or cut short, or of a rare kind: save it again")};
  };
  if (count > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw InputError(where, "the image " + file_in_quotes(name) + " is larger than 2 GiB");
  if (has_chunk_beyond_end(bytes, count))
    throw InputError(where, "the image " + file_in_quotes(name) + " is cut off: a part of it goes beyond the end");
  if (has_long_huffman_table(bytes, count))
    throw InputError(where, "the image " + file_in_quotes(name) + " has a Huffman table of more than 256 symbols");
  const int size = static_cast<int>(count);
  stb_largest = stb_own_memory + std::min<std::uintmax_t>(budget.left(), SIZE_MAX / 2);
  stb_refused = 0;
  int width = 0, height = 0, channels = 0;
  auto result = std::make_shared<scene::TextureImage>();
  const auto set_size = [&](int per_pixel) {
    result->resolution = {width, height};
    result->channels = per_pixel;
  };
  const auto pixel_count = [&] { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); };
  const auto is_number_of_alpha = [&](const auto* pixels, auto opaque) {
    if (part != TexturePart::number || channels != 4 || !is_rgba_png(bytes, count)) return false;
    for (std::size_t i = 0; i < pixel_count(); ++i)
      if (pixels[4 * i + 3] != opaque) return true;
    return false;
  };

  if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0) throw fail();
  const bool is_wide = stbi_is_hdr_from_memory(bytes, size) != 0 || stbi_is_16_bit_from_memory(bytes, size) != 0;
  // While it is decoded: what the library has, and what is kept of it.
  budget.take(pixel_count(), static_cast<std::uintmax_t>(channels) * (is_wide ? 8 : 2),
              "the image " + file_in_quotes(name), where);
  if (stbi_is_hdr_from_memory(bytes, size) != 0) {
    const Pixels<float> pixels(stbi_loadf_from_memory(bytes, size, &width, &height, &channels, 0), stbi_image_free);
    if (!pixels) throw fail();
    set_size(part == TexturePart::color && channels >= 3 ? 3 : 1);
    if (part == TexturePart::alpha)
      result->floats.assign(pixel_count(), 1.0F);  // such files have none
    else
      result->floats = picked(pixels.get(), pixel_count(), channels, part, [](float value) { return value; });
    return result;
  }
  if (stbi_is_16_bit_from_memory(bytes, size) != 0) {
    const Pixels<stbi_us> pixels(stbi_load_16_from_memory(bytes, size, &width, &height, &channels, 0), stbi_image_free);
    if (!pixels) throw fail();
    set_size(part == TexturePart::color && channels >= 3 ? 3 : 1);
    const auto linear = [&](stbi_us code) { return decode(code / 65535.0, encoding); };
    if (is_number_of_alpha(pixels.get(), stbi_us{65535})) {
      for (std::size_t i = 0; i < pixel_count(); ++i) result->floats.push_back(linear(pixels.get()[4 * i + 3]));
    } else if (part != TexturePart::alpha) {
      result->floats = picked(pixels.get(), pixel_count(), channels, part, linear);
    } else {
      for (std::size_t i = 0; i < pixel_count(); ++i)
        result->floats.push_back(
            channels % 2 != 0
                ? 1.0F
                : static_cast<float>(pixels.get()[(i + 1) * static_cast<std::size_t>(channels) - 1]) / 65535.0F);
    }
    return result;
  }
  const Pixels<stbi_uc> pixels(stbi_load_from_memory(bytes, size, &width, &height, &channels, 0), stbi_image_free);
  if (!pixels) throw fail();
  for (std::size_t i = 0; i < 256; ++i)
    result->decoded[i] =
        part == TexturePart::alpha ? static_cast<float>(i) / 255 : decode(static_cast<double>(i) / 255, encoding);
  const auto stride = static_cast<std::size_t>(channels);
  const bool is_alpha = part == TexturePart::alpha || is_number_of_alpha(pixels.get(), stbi_uc{255});
  if (!is_alpha && part != TexturePart::color && channels >= 3) {
    set_size(1);
    result->floats =
        picked(pixels.get(), pixel_count(), channels, part, [&](stbi_uc code) { return result->decoded[code]; });
    return result;
  }
  // As bytes: a quarter of the memory.
  const std::size_t first = is_alpha ? stride - 1 : 0;
  const std::size_t kept = part == TexturePart::color && channels >= 3 ? 3 : 1;
  const bool is_opaque = part == TexturePart::alpha && channels % 2 != 0;
  set_size(static_cast<int>(kept));
  for (std::size_t i = 0; i < pixel_count(); ++i)
    for (std::size_t c = 0; c < kept; ++c)
      result->bytes.push_back(is_opaque ? stbi_uc{255} : pixels.get()[i * stride + first + c]);
  return result;
}

#else

}  // namespace

Shared read_texture_image(const unsigned char*, std::size_t, const std::string& name, const TextureEncoding&,
                          TexturePart, LoadBudget&, const SourcePosition& where) {
  throw InputError(where, "the image " + file_in_quotes(name) +
                              " cannot be read: this program was built without the library stb, which reads PNG, TGA "
                              "and JPEG");
}

#endif

Shared read_texture_image(const std::filesystem::path& file, const TextureEncoding& encoding, TexturePart part,
                          LoadBudget& budget, const SourcePosition& where) {
  const std::string ending = ending_of(file);
  if (ending == ".exr" || ending == ".pfm") {
    try {
      budget.open_file(where);
      std::vector<float> alpha;
      const bool may_have_alpha = part == TexturePart::number && ending == ".exr";
      const Image image = read_image(file, &budget, may_have_alpha ? &alpha : nullptr);
      return from_floats(image, std::move(alpha), part);
    } catch (const InputError& read_error) {
      throw InputError(where, read_error.what());
    }
  }
  const std::string bytes = read_file(file, "the image", budget, where);
  return read_texture_image(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), file.string(), encoding,
                            part, budget, where);
}

}  // namespace gmis::tools
