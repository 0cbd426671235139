#include "adapters/agreement.hpp"
#include "embree/room.hpp"
#include "gmis/check/check_scene.hpp"
#include "support/catch.hpp"

TEST_CASE("with Embree's intersector the picture is that of the built-in scene") {
  const embree::Scene scene(room::build(24, 20), room::triangles());
  gmis::SceneCheckSettings settings;
  settings.seed = gmis_test::seed(3);
  CHECK(check_scene(scene, settings).text() == "");
  const auto built_in = room::build(24, 20);
  const auto a = gmis_test::tiles_of<gmis::Engine<embree::Scene>>(scene, gmis::integrators::bpt, 1, 200);
  const auto b =
      gmis_test::tiles_of<gmis::PathTracer<gmis::scene::BvhScene<float>>>(built_in, gmis::integrators::pt, 2, 400);
  gmis_test::check_same_picture(a, b);
}
