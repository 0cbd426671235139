#include "bring_your_own/adapter.hpp"

#include "adapters/agreement.hpp"
#include "bring_your_own/world.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "support/catch.hpp"

namespace {

/// The world of the other renderer, built of the library's own shapes, materials, lights and
/// camera.
auto built_in(const theirs::World& world, const std::vector<gmis::scene::Material<double>>& materials) {
  using namespace gmis::scene;
  SceneBuilder<double> builder;
  std::vector<std::size_t> numbers;
  for (const auto& material : materials) numbers.push_back(builder.add_material(material));
  const auto at = [](const theirs::Vector& v) { return glm::dvec3(v.x, v.y, v.z); };
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const theirs::Shape& shape = world.shapes[i];
    std::optional<AreaEmission> emission;
    if (shape.lamp != nullptr) emission = AreaEmission{at(shape.lamp->radiance)};
    if (shape.is_ball) {
      builder.add_sphere(at(shape.corner), shape.radius, numbers[i], emission);
      continue;
    }
    const glm::dvec3 corner = at(shape.corner), a = at(shape.side_a), b = at(shape.side_b);
    const std::vector<glm::dvec3> corners{corner, corner + a, corner + a + b, corner + b};
    const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
    builder.add_mesh({corners, triangles}, numbers[i], emission);
  }
  const theirs::Eye& eye = world.eye;
  const double degrees = 2 * std::atan(std::min(eye.half_width, eye.half_height)) * 180 / theirs::pi;
  builder.set_camera(
      look_at(at(eye.position), at(eye.position + eye.forward), at(eye.up), degrees, {eye.columns, eye.rows}));
  return builder.build();
}

}  // namespace

TEST_CASE("a renderer of another style makes the picture of the built-in scene") {
  using namespace gmis::scene;
  const theirs::World world = theirs::make_world(24, 20);
  const auto white = make_diffuse<double>({0.75, 0.7, 0.65}), red = make_diffuse<double>({0.6, 0.15, 0.1}),
             black = make_diffuse<double>({0, 0, 0});
  const auto scene = built_in(world, {white, white, red, make_dielectric<double>(1.5), red, black, black});
  const adapter::Scene adapted(world);
  // Two integrators without bias: one pairs every technique of the one with every technique of the
  // other.
  const auto a = gmis_test::tiles_of<gmis::Engine<adapter::Scene>>(adapted, gmis::integrators::bpt, 1, 200);
  const auto b = gmis_test::tiles_of<gmis::PathTracer<BvhScene<double>>>(scene, gmis::integrators::pt, 2, 400);
  gmis_test::check_same_picture(a, b);
}
