#pragma once

#include "support/build_scene.hpp"

namespace gmis::tools {

/// Whether 256 directions, spread evenly over the sphere around the camera's point, all end on a
/// surface. A gap below about 0.05 sr may be missed.
[[nodiscard]] bool camera_is_enclosed(const BuiltScene& scene);

}  // namespace gmis::tools
