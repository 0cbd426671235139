#pragma once

#include "support/image/image.hpp"

namespace gmis::tools {

/// The relative error of every pixel and channel, |x − ref| / √(ref² + 0.01).
[[nodiscard]] Image pixel_error(const Image& image, const Image& reference);

/// The relative error of every pixel, the root of the mean square over its channels, in colours
/// from black (1 % and less) over violet and orange to pale yellow (100 % and more), on a
/// logarithmic scale.
[[nodiscard]] Image error_map(const Image& pixel_error);

/// The factor that brings the reference's brightest few per cent to white.
[[nodiscard]] float exposure_of(const Image& reference);

}  // namespace gmis::tools
