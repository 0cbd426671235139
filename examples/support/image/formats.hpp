#pragma once

#include <filesystem>

#include "support/image/image.hpp"
#include "support/load_budget.hpp"

/// \file
/// One pair of functions per format; `write_image` and `read_image` choose among them. They throw
/// `InputError` or, when a file cannot be written, `OutputError`.

namespace gmis::tools {

/// Counts the pixels of an image that is about to be read.
inline void count_pixels(LoadBudget* budget, const std::filesystem::path& file, int width, int height) {
  if (budget == nullptr) return;
  budget->take(static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height), 3 * sizeof(float),
               "the image " + file_in_quotes(file.string()), {});
}

/// Float RGB, little-endian, rows from the bottom.
void write_pfm(const Image& image, const std::filesystem::path& file);
/// Colour or grey, either byte order; values times the size of the number in the header.
[[nodiscard]] Image read_pfm(const std::filesystem::path& file, LoadBudget* budget = nullptr);

/// Float RGB, ZIP-compressed; a layer has its name and a dot before the letters of its channels,
/// notes are attributes.
[[nodiscard]] bool has_exr();
void write_exr(const Image& image, const std::filesystem::path& file, const ImageExtras& extras = {});
/// Channels R, G and B, or grey: Y, or the only channel. Others are left out; `alpha` as in
/// `read_image`.
[[nodiscard]] Image read_exr(const std::filesystem::path& file, LoadBudget* budget = nullptr,
                             std::vector<float>* alpha = nullptr);

/// 8 bits a channel: each value times `exposure`, brought to [0, 1] by `tone`, with the sRGB curve;
/// notes are texts in UTF-8 (chunks iTXt).
[[nodiscard]] bool has_png();
void write_png(const Image& image, const std::filesystem::path& file, const ImageExtras& extras = {});
/// The bytes of such a file without notes.
[[nodiscard]] std::vector<std::uint8_t> png_of(const Image& image, float exposure = 1,
                                               ToneCurve tone = ToneCurve::clamp);

}  // namespace gmis::tools
