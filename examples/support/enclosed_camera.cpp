#include "support/enclosed_camera.hpp"

#include <cmath>
#include <numbers>

namespace gmis::tools {

bool camera_is_enclosed(const BuiltScene& scene) {
  const auto& world = scene.scene();
  const auto ray = world.camera().sample_ray(world.camera().resolution() / 2, glm::vec2(0.5F), glm::vec2(0.5F));
  if (!ray) return false;
  constexpr int count = 256;
  constexpr double golden_angle = 2 * std::numbers::pi / (std::numbers::phi * std::numbers::phi);
  for (int i = 0; i < count; ++i) {  // a spiral of equal areas
    const double z = 1 - (2 * i + 1.0) / count, radius = std::sqrt(1 - z * z), angle = i * golden_angle;
    const glm::vec3 direction(radius * std::cos(angle), radius * std::sin(angle), z);
    if (!world.intersect({ray->origin.position, direction})) return false;
  }
  return true;
}

}  // namespace gmis::tools
