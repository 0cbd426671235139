#pragma once

#include "bvh/meshes.hpp"
#include "gmis/core/interaction.hpp"

/// \file
/// Rays as a renderer makes them: from the camera, from where these hit in directions by the
/// cosine, and from there to a light.

namespace bench_bvh {

using gmis::Ray;

struct RaySet {
  const char* name;
  bool any_hit;  ///< asks only whether something is in the way
  std::vector<Ray<float>> rays;
};

/// `size`² pixels, each row from left to right; bounces and shadows in the order of the pixels they
/// come from.
inline std::vector<RaySet> make_rays(const Mesh& mesh, const gmis::scene::BuiltBvh<float>& built, int size) {
  std::vector<RaySet> sets{{"camera", false, {}}, {"diffuse", false, {}}, {"shadow", true, {}}};
  Philox source(3);
  const Vec3<float> forward = glm::normalize(mesh.target - mesh.eye);
  const Vec3<float> right = glm::normalize(glm::cross(Vec3<float>(0, 1, 0), forward));
  const Vec3<float> up = glm::cross(forward, right);
  constexpr float half_width = 0.45F;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float u = (static_cast<float>(x) + uniform<float>(source)) / static_cast<float>(size) * 2 - 1;
      const float v = (static_cast<float>(y) + uniform<float>(source)) / static_cast<float>(size) * 2 - 1;
      const Ray<float> ray{mesh.eye, glm::normalize(forward + right * (u * half_width) - up * (v * mesh.half_height))};
      sets[0].rays.push_back(ray);
      const auto hit = built.bvh.closest(ray);
      if (hit.kind != gmis::scene::BvhChild::triangles) continue;
      const auto& t = mesh.triangles[built.triangle_in_slot[hit.slot]];
      const Vec3<float> a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      Vec3<float> normal = glm::normalize(glm::cross(b - a, c - a));
      if (glm::dot(normal, ray.direction) > 0) normal = -normal;
      const auto& w = hit.corner_weights;
      const Vec3<float> on_surface = (a * w[0] + b * w[1] + c * w[2]) / (w[0] + w[1] + w[2]);
      const Vec3<float> origin = on_surface + normal * (1e-5F * (1 + glm::length(on_surface)));
      const float u1 = uniform<float>(source), u2 = uniform<float>(source);
      const Vec3<float> local = gmis::square_to_cosine_hemisphere(gmis::Vec2<float>(u1, u2));
      sets[1].rays.push_back({origin, glm::normalize(gmis::Frame<float>::around(normal).to_world(local))});
      const Vec3<float> to_light = mesh.light + random_in_cube(source) * (mesh.light_size / 2) - origin;
      if (glm::dot(to_light, normal) <= 0) continue;
      const float distance = glm::length(to_light);
      sets[2].rays.push_back({origin, to_light / distance, distance});
    }
  return sets;
}

}  // namespace bench_bvh
