#pragma once

#include <functional>
#include <string>

#include "support/image/image.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools {

/// A sky for a model without a light: a large key above the left shoulder of one who looks along
/// −z, a fill from the right, a rim from behind, a floor and a background that are darker. Made by
/// a formula; y is up.
[[nodiscard]] EnvironmentLightDescription studio_sky();
/// Its radiance from a unit direction.
[[nodiscard]] glm::dvec3 studio_radiance(const glm::dvec3& direction);

/// An image of the sky as a light has it.
struct SkyImage {
  scene::EnvironmentImage image;
  bool has_negative = false;  ///< values below 0, which are 0 in `image`
};
/// The image with every value times `scale`. One that is square is equal-area, one that is twice as
/// wide as high has latitude and longitude. `fail`, which throws, gets what follows the name of
/// another image, or of one with a value that is no number or above 1e20.
[[nodiscard]] SkyImage sky_image(const Image& image, double scale, const std::function<void(const std::string&)>& fail);

/// Replaces every light that surrounds the scene: by "studio", "white" (radiance 1), nothing
/// ("none"), or an image, .exr or .pfm, as pbrt's infinite lights have them (y is then up). Throws
/// `InputError` for another name.
void replace_sky(SceneDescription& scene, const std::string& name);

}  // namespace gmis::tools
