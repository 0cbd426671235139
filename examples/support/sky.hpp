#pragma once

#include <string>

#include "support/scene_description.hpp"

namespace gmis::tools {

/// A sky for a model without a light: a large key above the left shoulder of one who looks along
/// −z, a fill from the right, a rim from behind, a floor and a background that are darker. Made by
/// a formula; y is up.
[[nodiscard]] EnvironmentLightDescription studio_sky();
/// Its radiance from a unit direction.
[[nodiscard]] glm::dvec3 studio_radiance(const glm::dvec3& direction);

/// Replaces every light that surrounds the scene: by "studio", "white" (radiance 1), nothing
/// ("none"), or an image, .exr or .pfm, as pbrt's infinite lights have them (y is then up). Throws
/// `InputError` for another name.
void replace_sky(SceneDescription& scene, const std::string& name);

}  // namespace gmis::tools
