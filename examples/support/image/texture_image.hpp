#pragma once

#include <filesystem>
#include <memory>

#include "gmis/scene/texture.hpp"
#include "support/load_budget.hpp"

namespace gmis::tools {

/// How the 8 or 16 bits of a channel stand for a linear value.
struct TextureEncoding {
  enum class Curve { srgb, linear, gamma } curve = Curve::srgb;
  double gamma = 2.2;  ///< value = code^gamma
};
/// `grey`: the mean of the colours as one channel. `alpha`: the last of two or four channels, 1
/// where there is none. `number`: what pbrt makes of an image for a texture of type float, the
/// alpha of an .exr or a .png of type RGBA where it is not 1 everywhere, with the encoding of the
/// colours; else `grey`.
enum class TexturePart { color, grey, alpha, number };

/// Reads .png, .tga, .jpg, .bmp and .hdr by the library stb_image, .exr and .pfm by `read_image`.
/// Files of floats are linear whatever the encoding. Throws `InputError`, which names `where`, when
/// the image is missing or cannot be read.
[[nodiscard]] std::shared_ptr<const scene::TextureImage> read_texture_image(const std::filesystem::path& file,
                                                                            const TextureEncoding& encoding,
                                                                            TexturePart part, LoadBudget& budget,
                                                                            const SourcePosition& where);

/// `read_texture_image`, for a file in memory, such as one inside a glTF file; `name` stands for it
/// in messages.
[[nodiscard]] std::shared_ptr<const scene::TextureImage> read_texture_image(const unsigned char* bytes,
                                                                            std::size_t count, const std::string& name,
                                                                            const TextureEncoding& encoding,
                                                                            TexturePart part, LoadBudget& budget,
                                                                            const SourcePosition& where);

}  // namespace gmis::tools
