#pragma once

#include <array>
#include <vector>

#include "embree_scene.hpp"

/// A room of parallelograms with two lamps, a mirror and a glass plate.
namespace room {

struct Wall {
  glm::dvec3 corner, a, b;
  int material;
  glm::dvec3 radiance{0};
};

inline const std::vector<Wall>& walls() {
  static const std::vector<Wall> all{
      {{-2, 0, -2}, {0, 0, 4}, {4, 0, 0}, 0},                   // floor
      {{-2, 0, 2}, {0, 4, 0}, {4, 0, 0}, 0},                    // back
      {{-2, 0, -2}, {0, 4, 0}, {0, 0, 4}, 1},                   // side
      {{0.4, 0, 1.8}, {1.2, 0, -0.6}, {0, 1.5, 0}, 2},          // mirror
      {{-1.2, 0.2, -0.8}, {1, 0, 0.3}, {0, 1.2, 0}, 3},         // the front of a thick pane of glass
      {{-1.2, 0.2, -0.6}, {0, 1.2, 0}, {1, 0, 0.3}, 3},         // and its back
      {{-0.5, 3.9, -0.5}, {1, 0, 0}, {0, 0, 1}, 4, {9, 9, 8}},  // lamp
      {{1.9, 1.5, 0}, {0, 0, 0.5}, {0, 0.5, 0}, 4, {4, 6, 8}},  // a smaller one
  };
  return all;
}

inline std::vector<embree::Scene::Corners> triangles() {
  std::vector<embree::Scene::Corners> result;
  for (const Wall& wall : walls()) {
    result.push_back({wall.corner, wall.corner + wall.a, wall.corner + wall.a + wall.b});
    result.push_back({wall.corner, wall.corner + wall.a + wall.b, wall.corner + wall.b});
  }
  return result;
}

inline gmis::scene::BvhScene<float> build(int width, int height) {
  using namespace gmis::scene;
  SceneBuilder<> builder;
  const std::array materials{builder.add_material(make_diffuse({0.75, 0.7, 0.65})),
                             builder.add_material(make_phong({0.4, 0.1, 0.1}, {0.3, 0.3, 0.3}, 30)),
                             builder.add_material(make_mirror({0.9, 0.9, 0.9})),
                             builder.add_material(make_dielectric(1.5)), builder.add_material(make_diffuse({0, 0, 0}))};
  for (const Wall& wall : walls()) {
    const std::vector<glm::dvec3> corners{wall.corner, wall.corner + wall.a, wall.corner + wall.a + wall.b,
                                          wall.corner + wall.b};
    const std::vector<std::array<int, 3>> two{{0, 1, 2}, {0, 2, 3}};
    std::optional<AreaEmission> emission;
    if (wall.radiance != glm::dvec3(0)) emission = AreaEmission{wall.radiance};
    builder.add_mesh({corners, two}, materials[static_cast<std::size_t>(wall.material)], emission);
  }
  builder.set_camera(look_at({0, 1.8, -6}, {0, 1.8, 0}, {0, 1, 0}, 48, {width, height}));
  return builder.build();
}

}  // namespace room
