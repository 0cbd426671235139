#include <algorithm>
#include <string_view>

#include "fuzz/input.hpp"
#include "support/image/texture_image.hpp"

// The reader of images for textures (PNG, TGA, JPEG, BMP, HDR): whatever the bytes are, an image
// with all its pixels, or an InputError of one line. The budget is small, so that large pictures
// are refused and the time goes to many inputs.

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gmis::tools;
  for (const TexturePart part : {TexturePart::color, TexturePart::grey, TexturePart::alpha, TexturePart::number}) {
    LoadBudget budget(std::uintmax_t{16} << 10);
    try {
      const auto image = read_texture_image(data, size, "input", {}, part, budget, {});
      const auto texels = static_cast<std::size_t>(image->resolution.x) * static_cast<std::size_t>(image->resolution.y);
      fuzz::require(texels > 0, "an image has pixels");
      fuzz::require(
          std::max(image->bytes.size(), image->floats.size()) == texels * static_cast<std::size_t>(image->channels),
          "all pixels are there");
    } catch (const InputError& error) {
      fuzz::require(std::string_view(error.what()).find('\n') == std::string_view::npos, "an error is one line");
    }
  }
  return 0;
}
