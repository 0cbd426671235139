#pragma once

#include <vector>

#include "support/build_scene.hpp"
#include "support/executor.hpp"
#include "support/image/image.hpp"

namespace gmis::tools {

/// The surfaces that camera rays hit first, the mean of 16 rays a pixel: `albedo` (RGB), `normal`
/// (XYZ, the shading normal on the side of the camera, in the world) and `depth` (Z, the distance
/// from the camera's point, of the rays that hit anything). All are 0 where nothing is hit. A
/// denoiser takes the first two beside the picture.
[[nodiscard]] std::vector<ImageLayer> first_hit_layers(const BuiltScene& scene, const std::optional<PixelBounds>& crop,
                                                       ThreadedExecutor& executor);

}  // namespace gmis::tools
