#pragma once

#include "support/image/image.hpp"

namespace gmis::tools {

/// True when this program is built with Open Image Denoise.
[[nodiscard]] bool has_denoiser();

/// `noisy` as Open Image Denoise smooths it; `albedo` and `normal`, of the same size, are those of
/// `first_hit_layers`. Throws `OutputError` when the library fails or is not there.
[[nodiscard]] Image denoised(Image noisy, Image albedo, Image normal);

}  // namespace gmis::tools
