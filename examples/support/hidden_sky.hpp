#pragma once

#include "support/build_scene.hpp"

namespace gmis::tools {

/// Whether surfaces hide the sky from the picture: 32 × 32 rays through it all end on surfaces, and
/// so do 8 rays in all directions from each of these points. A small gap may be missed.
[[nodiscard]] bool sky_is_hidden(const BuiltScene& scene);

}  // namespace gmis::tools
