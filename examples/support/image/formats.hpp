#pragma once

#include <filesystem>

#include "support/image/image.hpp"

/// \file
/// One pair of functions per format; `write_image` and `read_image` choose among them. They throw `InputError` or,
/// when a file cannot be written, `OutputError`.

namespace gmis::tools {

/// Float RGB, little-endian, rows from the bottom.
void write_pfm(const Image& image, const std::filesystem::path& file);
/// Colour or grey, either byte order.
[[nodiscard]] Image read_pfm(const std::filesystem::path& file);

/// Float RGB, ZIP-compressed.
[[nodiscard]] bool has_exr();
void write_exr(const Image& image, const std::filesystem::path& file);
[[nodiscard]] Image read_exr(const std::filesystem::path& file);

/// 8 bits a channel with the sRGB curve; values outside [0, 1] are cut.
[[nodiscard]] bool has_png();
void write_png(const Image& image, const std::filesystem::path& file);
/// The bytes of such a file, each value times `exposure`.
[[nodiscard]] std::vector<std::uint8_t> png_of(const Image& image, float exposure = 1);

}  // namespace gmis::tools
