#include "support/hidden_sky.hpp"

#include <cmath>
#include <numbers>

namespace gmis::tools {
namespace {

/// Number `i` of `count` directions along a spiral over the sphere, each for the same solid angle.
glm::vec3 spiral_direction(int i, int count) {
  constexpr double golden_angle = 2 * std::numbers::pi / (std::numbers::phi * std::numbers::phi);
  const double z = 1 - (2 * i + 1.0) / count, radius = std::sqrt(1 - z * z), angle = i * golden_angle;
  return glm::vec3(radius * std::cos(angle), radius * std::sin(angle), z);
}

}  // namespace

bool sky_is_hidden(const BuiltScene& scene) {
  const auto& world = scene.scene();
  const glm::ivec2 resolution = world.camera().resolution();
  constexpr int side = 32, rays = 8;
  for (int i = 0; i < side * side; ++i) {
    const glm::ivec2 pixel(i % side * resolution.x / side, i / side * resolution.y / side);
    const auto ray = world.camera().sample_ray(pixel, glm::vec2(0.5F), glm::vec2(0.5F));
    if (!ray) continue;
    const auto hit = world.intersect({ray->origin.position, ray->direction});
    if (!hit) return false;
    // A little before the surface, so that it is not hit again at once.
    const glm::vec3 before = glm::mix(hit->point.position, ray->origin.position, 1e-3F);
    for (int j = 0; j < rays; ++j)
      if (!world.intersect({before, spiral_direction(rays * i + j, rays * side * side)})) return false;
  }
  return true;
}

}  // namespace gmis::tools
