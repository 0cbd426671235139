#include "support/first_hit_layers.hpp"

#include <cmath>

namespace gmis::tools {

std::vector<ImageLayer> first_hit_layers(const BuiltScene& scene, const std::optional<PixelBounds>& crop,
                                         ThreadedExecutor& executor) {
  const auto& world = scene.scene();
  const PixelBounds part = crop.value_or(PixelBounds{{0, 0}, world.camera().resolution()});
  const glm::ivec2 size = part.upper - part.lower;
  Image albedo(size.x, size.y), normal(size.x, size.y), depth(size.x, size.y);
  executor.parallel_for(static_cast<std::size_t>(size.y), [&](std::size_t row) {
    for (int x = 0; x < size.x; ++x) {
      const int y = static_cast<int>(row);
      constexpr int side = 4;
      glm::vec3 color(0), direction(0);
      float distance = 0, hits = 0;
      for (int i = 0; i < side * side; ++i) {
        const glm::vec2 in_pixel((static_cast<float>(i % side) + 0.5F) / side,
                                 (static_cast<float>(i / side) + 0.5F) / side);
        // On the lens another order, so that both are spread evenly.
        const int j = (5 * i + 3) % (side * side);
        const glm::vec2 on_lens((static_cast<float>(j % side) + 0.5F) / side,
                                (static_cast<float>(j / side) + 0.5F) / side);
        const auto ray = world.camera().sample_ray(part.lower + glm::ivec2(x, y), in_pixel, on_lens);
        if (!ray) continue;
        const auto hit = world.intersect({ray->origin.position, ray->direction});
        if (!hit) continue;
        const glm::vec3& n = hit->point.shading_normal;
        color += hit->bsdf.albedo();
        direction += glm::dot(n, ray->direction) > 0 ? -n : n;
        distance += glm::length(hit->point.position - ray->origin.position);
        hits += 1;
      }
      const std::size_t first = albedo.index(x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        albedo.rgb[first + c] = std::min(color[static_cast<int>(c)] / (side * side), 1.0F);
        normal.rgb[first + c] = direction[static_cast<int>(c)] / (side * side);
      }
      depth.rgb[first] = hits > 0 ? distance / hits : 0;
    }
  });
  return {{"albedo", "RGB", std::move(albedo)}, {"normal", "XYZ", std::move(normal)}, {"depth", "Z", std::move(depth)}};
}

}  // namespace gmis::tools
