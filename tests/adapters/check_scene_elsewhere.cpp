#include <algorithm>
#include <vector>

#include "adapters/planted_mistakes.hpp"
#include "bring_your_own/adapter.hpp"
#include "bring_your_own/world.hpp"
#include "support/catch.hpp"

// The mistakes of check_scene.cpp once more, where precision and conventions differ.

using namespace gmis_test;

TEST_CASE("the same mistakes in double precision") {
  const auto scene = built_in_scene<double>();
  for (const Planted& one : planted) {
    INFO("mistake " << static_cast<int>(one.mistake));
    CHECK(check_scene(BrokenScene(scene, one.mistake), check_settings()).is_broken(one.wanted));
  }
}

TEST_CASE("the same mistakes in the adapter of a renderer of another style") {
  const theirs::World world = theirs::make_world(64, 48);
  const adapter::Scene scene(world);
  gmis::SceneCheckSettings many = check_settings();
  many.samples *= 4;  // all is diffuse: a wrong density differs less than at a narrow lobe
  CHECK(gmis::check_scene(scene, check_settings()).text() == "");
  CHECK(check_scene(BrokenScene(scene, Mistake::none), many).text() == "");
  // It has no delta light, no infinite light, no surface that transmits but delta ones, and a
  // distance of its own that keeps rays off surfaces.
  const std::vector<Mistake> impossible{Mistake::no_offset,          Mistake::infinite_lights_empty,
                                        Mistake::delta_density_zero, Mistake::delta_light_falls_linearly,
                                        Mistake::disk_area_halved,   Mistake::reflects_only_wrong};
  for (const Planted& one : planted) {
    if (std::find(impossible.begin(), impossible.end(), one.mistake) != impossible.end()) continue;
    const gmis::Findings findings = check_scene(BrokenScene(scene, one.mistake), many);
    // All that refracts here is a delta lobe.
    const Convention wanted = one.mistake == Mistake::mode_ignored ? Convention::bsdf_delta_adjoint : one.wanted;
    INFO("mistake " << static_cast<int>(one.mistake) << ", wanted: " << sentence_of(wanted));
    INFO("said:\n" << findings.text());
    CHECK(findings.is_broken(wanted));
  }
}
