#pragma once

#include "support/render.hpp"

namespace gmis::tools {

/// The engines that the request asks for: light trees that split, or engines with a pilot.
[[nodiscard]] EngineMaker<SceneSpectrum> engines_for(const BuiltScene& scene, const RenderRequest& request);

}  // namespace gmis::tools
