#include <cmath>

#include "adapters/agreement.hpp"
#include "gmis/check/check_scene.hpp"
#include "gmis/check/explain.hpp"
#include "gmis/scene/scene_builder.hpp"
#include "many_lights/adapter.hpp"
#include "support/catch.hpp"

namespace {

/// The town, built of the library's own shapes, materials, lights and camera.
auto built_in(const town::Town& town) {
  using namespace gmis::scene;
  SceneBuilder<float> builder;
  for (const town::Patch& patch : town.patches) {
    const auto material = builder.add_material(make_diffuse(patch.colour));
    const glm::dvec3 corner(patch.corner), a(patch.side_a), b(patch.side_b);
    const std::vector<glm::dvec3> corners{corner, corner + a, corner + a + b, corner + b};
    builder.add_mesh({corners, std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}}, material);
  }
  const auto black = builder.add_material(make_diffuse({0, 0, 0}));
  for (const town::Lamp& lamp : town.lamps)
    builder.add_sphere(glm::dvec3(lamp.center), static_cast<double>(lamp.radius), black,
                       AreaEmission{glm::dvec3(lamp.radiance)});
  const town::Eye& eye = town.eye;
  const double degrees =
      2 * std::atan(static_cast<double>(std::min(eye.half_width, eye.half_height))) * 180 / gmis::pi<double>;
  builder.set_camera(look_at(glm::dvec3(eye.position), glm::dvec3(eye.position + eye.forward), glm::dvec3(eye.up),
                             degrees, {eye.columns, eye.rows}));
  return builder.build();
}

/// Geometric mean over the tiles of the ratio of their variances. A sum would be ruled by the tiles
/// that see a lamp's edge.
double variance_ratio(const gmis_test::TileMeans& a, const gmis_test::TileMeans& b) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < a.squares.size(); ++i)
    if (a.squares[i] > 0 && b.squares[i] > 0) {
      sum += std::log(a.squares[i] / b.squares[i]);
      ++count;
    }
  return std::exp(sum / count);
}

}  // namespace

TEST_CASE("a renderer that chooses lights for their receiver makes the picture of the built-in scene") {
  const town::Town town = town::make_town(24, 24, 20);
  const many_lights::Scene<true> by_grid(town);
  const many_lights::Scene<false> alike(town);
  const auto scene = built_in(town);
  const auto truth =
      gmis_test::tiles_of<gmis::PathTracer<gmis::scene::BvhScene<>>>(scene, gmis::integrators::pt, 1, 600);
  const auto traced =
      gmis_test::tiles_of<gmis::PathTracer<many_lights::Scene<true>>>(by_grid, gmis::integrators::pt, 2, 300);
  gmis_test::check_same_picture(traced, truth);
  // Every technique of the one against the emitter hits and next events of the other.
  const auto both =
      gmis_test::tiles_of<gmis::Engine<many_lights::Scene<true>>>(by_grid, gmis::integrators::bpt, 3, 300);
  gmis_test::check_same_picture(both, truth);
  // The reason to choose lamps by the grid, in small tiles, most of which see no lamp's edge.
  const auto with =
      gmis_test::tiles_of<gmis::PathTracer<many_lights::Scene<true>>>(by_grid, gmis::integrators::pt, 2, 300, 4);
  const auto without =
      gmis_test::tiles_of<gmis::PathTracer<many_lights::Scene<false>>>(alike, gmis::integrators::pt, 4, 300, 4);
  CHECK(variance_ratio(with, without) < 0.6);
}

TEST_CASE("the adapter of a renderer that chooses lights for their receiver is sound") {
  const town::Town town = town::make_town(24, 64, 48);
  gmis::SceneCheckSettings settings;
  settings.seed = gmis_test::seed(5);
  CHECK(gmis::check_scene(many_lights::Scene<true>(town), settings).text() == "");
  CHECK(gmis::check_scene(many_lights::Scene<false>(town), settings).text() == "");
  CHECK(gmis::explain(many_lights::Scene<true>(town)).find("sample_light(from, u)") == std::string::npos);
  CHECK(gmis::explain(many_lights::Scene<false>(town)).find("sample_light(from, u)") != std::string::npos);
}
