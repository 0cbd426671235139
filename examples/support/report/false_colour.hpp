#pragma once

#include "support/image/image.hpp"

namespace gmis::tools {

/// The relative error of every pixel, √(mean over channels of (x − ref)² / (ref² + 0.01)), in colours from black (1 % and
/// less) over violet and orange to pale yellow (100 % and more), even steps for even factors.
[[nodiscard]] Image error_map(const Image& image, const Image& reference);

/// The factor that brings the reference's brightest few per cent to white.
[[nodiscard]] float exposure_of(const Image& reference);

}  // namespace gmis::tools
