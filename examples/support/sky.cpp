#include "support/sky.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "support/file_ending.hpp"
#include "support/load_budget.hpp"

namespace gmis::tools {
namespace {

/// The image's z is up in the world's y.
glm::dmat3 y_is_up() {
  return {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
}

EnvironmentLightDescription sky_of_image(const std::string& name) {
  LoadBudget budget;
  EnvironmentLightDescription sky;
  sky.world_from_sky = y_is_up();
  sky.image = sky_image(read_image(name, &budget), 1, [&](const std::string& message) {
                throw InputError(name + ": this sky " + message);
              }).image;
  return sky;
}

}  // namespace

glm::dvec3 studio_radiance(const glm::dvec3& direction) {
  const auto lobe = [&](const glm::dvec3& axis, double width) {
    return std::exp((glm::dot(direction, glm::normalize(axis)) - 1) / width);
  };
  const double above = glm::smoothstep(-0.15, 0.5, direction.y);
  const glm::dvec3 room = glm::mix(glm::dvec3(0.10, 0.10, 0.11), glm::dvec3(0.38, 0.40, 0.43), above);
  return room + glm::dvec3(7.0, 6.8, 6.5) * lobe({-0.6, 0.8, 0.7}, 0.05) +
         glm::dvec3(0.75, 0.8, 0.9) * lobe({0.9, 0.25, 0.5}, 0.15) +
         glm::dvec3(1.6, 1.6, 1.7) * lobe({0.3, 0.5, -1.0}, 0.06);
}

EnvironmentLightDescription studio_sky() {
  EnvironmentLightDescription sky;
  constexpr int width = 256, height = 128;
  sky.image.resolution = {width, height};
  sky.image.mapping = scene::SkyMapping::latitude_longitude;
  sky.world_from_sky = y_is_up();
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double theta = (row + 0.5) / height * std::numbers::pi, phi = (column + 0.5) / width * 2 * std::numbers::pi;
      const glm::dvec3 in_sky(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      sky.image.radiance.emplace_back(studio_radiance(sky.world_from_sky * in_sky));
    }
  return sky;
}

SkyImage sky_image(const Image& image, double scale, const std::function<void(const std::string&)>& fail) {
  SkyImage sky;
  sky.image.resolution = {image.width, image.height};
  if (image.width == 2 * image.height)
    sky.image.mapping = scene::SkyMapping::latitude_longitude;
  else if (image.width != image.height)
    fail("has " + std::to_string(image.width) + " by " + std::to_string(image.height) +
         " pixels: it must be square (equal-area octahedral, as pbrt-v4 has it) or twice as wide as high (latitude and "
         "longitude)");
  sky.image.radiance.reserve(image.rgb.size() / 3);
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    glm::vec3 radiance(0);
    for (int c = 0; c < 3; ++c) {
      const double value = scale * static_cast<double>(image.rgb[i + static_cast<std::size_t>(c)]);
      if (!(value <= 1e20)) fail("has a value that is no number or above 1e20");
      sky.has_negative = sky.has_negative || value < 0;
      radiance[c] = static_cast<float>(std::max(value, 0.0));
    }
    sky.image.radiance.push_back(radiance);
  }
  return sky;
}

void replace_sky(SceneDescription& scene, const std::string& name) {
  const auto is_sky = [](const LightDescription& light) {
    return std::holds_alternative<InfiniteLightDescription>(light.kind) ||
           std::holds_alternative<EnvironmentLightDescription>(light.kind);
  };
  LightDescription sky{InfiniteLightDescription{Rgb(1)}, {}};
  const std::string ending = ending_of(name);
  if (name == "studio")
    sky.kind = studio_sky();
  else if (ending == ".exr" || ending == ".pfm") {
    sky.kind = sky_of_image(name);
    add_file(scene, name);
  } else if (name != "white" && name != "none")
    throw InputError("--sky " + in_quotes(name) + " is not known: use studio, white, none or an .exr or .pfm image");
  std::erase_if(scene.lights, is_sky);
  if (name != "none") scene.lights.push_back(std::move(sky));
}

}  // namespace gmis::tools
