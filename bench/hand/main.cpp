// Renders one of a few scenes by the engine (`pt`) or by the path tracer written by hand (`hand`),
// and prints the sum of all values. bench/benches/hand_path_tracer.py counts what each takes.
//
// Usage: hand_path_tracer hand|pt box|glossy|sky|point ITERATIONS

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "gmis/scene/scene_builder.hpp"
#include "hand/sums.hpp"

namespace {

using namespace gmis::scene;

constexpr int size = 64;

void add_quad(SceneBuilder<float>& builder, const glm::dvec3& corner, const glm::dvec3& a, const glm::dvec3& b,
              std::size_t material, const std::optional<AreaEmission>& emission = {}) {
  const glm::dvec3 positions[] = {corner, corner + a, corner + a + b, corner + b};
  const std::array<int, 3> triangles[] = {{0, 1, 2}, {0, 2, 3}};
  builder.add_mesh({positions, triangles}, material, emission);
}

/// A room with two balls, lit in one way or another.
gmis::scene::BvhScene<float> scene_named(std::string_view name) {
  SceneBuilder<float> builder;
  const auto white = builder.add_material(make_diffuse({.75, .75, .75}));
  const auto red = builder.add_material(make_diffuse({.6, .2, .2}));
  const auto left =
      builder.add_material(name == "glossy" ? make_phong({.3, .3, .3}, {.4, .4, .4}, 60) : make_mirror({.9, .9, .9}));
  const auto right =
      builder.add_material(name == "glossy" ? make_coated_diffuse({.5, .5, .2}, 1.5, .2) : make_dielectric(1.5));
  add_quad(builder, {-1, -1, -1}, {2, 0, 0}, {0, 0, 2}, white);
  if (name != "sky") {
    add_quad(builder, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0}, white);
    add_quad(builder, {-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, white);
    add_quad(builder, {-1, -1, -1}, {0, 0, 2}, {0, 2, 0}, red);
    add_quad(builder, {1, -1, -1}, {0, 2, 0}, {0, 0, 2}, red);
  }
  builder.add_sphere({-.45, -.6, .3}, .4, left);
  builder.add_sphere({.45, -.65, -.2}, .35, right);
  if (name == "sky")
    builder.add_environment({.6, .8, 1});
  else if (name == "point")
    builder.add_point_light({0, .7, -.3}, {1, 1, 1});
  else
    add_quad(builder, {-.3, .99, -.3}, {0, 0, .6}, {.6, 0, 0}, white, AreaEmission{{12, 12, 10}, true});
  builder.set_camera(look_at({0, 0, -3.4}, {0, 0, 0}, {0, 1, 0}, 40, {size, size}));
  return builder.build();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "Usage: hand_path_tracer hand|pt box|glossy|sky|point ITERATIONS\n");
    return 2;
  }
  const auto scene = scene_named(argv[2]);
  const auto iterations = static_cast<std::uint32_t>(std::atoi(argv[3]));
  const bool is_by_hand = std::string_view(argv[1]) == "hand";
  std::printf("%.9g\n", is_by_hand ? hand::sum_by_hand(scene, iterations) : hand::sum_by_engine(scene, iterations));
  return 0;
}
