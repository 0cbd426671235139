#include "gmis/transport/dispatch.hpp"

#include <cstdio>
#include <string>
#include <type_traits>

#include "gmis/transport/effects/effect_switches.hpp"
#include "support/catch.hpp"
#include "transport/furnace_scene.hpp"

namespace {

/// The techniques of the integrator that a plan is given to, and whether it classifies.
struct Compiled {
  bool connects, splats, merges, classifies;
  friend bool operator==(const Compiled&, const Compiled&) = default;
};

Compiled compiled_for(const gmis::Plan& plan) {
  return gmis::dispatch(plan, []<class I>() {
    static_assert(I::template has<gmis::EmitterHit> && I::template has<gmis::NextEvent> && !I::Split::splits_light &&
                  !I::Split::splits_camera);
    return Compiled{I::template has<gmis::Connect>, I::template has<gmis::Splat>, I::template has<gmis::Merge>,
                    std::is_same_v<typename I::Path, gmis::HalfPath>};
  });
}

}  // namespace

TEST_CASE("a plan is given to the integrator that has just its techniques") {
  gmis::Effects effects;
  effects.diffuse = effects.area_lights = true;
  CHECK(compiled_for(gmis::plan_for(effects, 2)) == Compiled{false, false, false, false});
  CHECK(compiled_for(gmis::plan_for(effects, 8)) == Compiled{true, true, false, false});
  effects.specular_reflection = true;
  CHECK(compiled_for(gmis::plan_for(effects, 8)) == Compiled{true, true, true, false});
  const auto switched = [&](const char* list) {
    return compiled_for(gmis::plan_for(effects, 8, gmis::switched_effects(list).classes));
  };
  CHECK(switched("direct-only") == Compiled{false, false, false, true});
  CHECK(switched("LDE-only,LS+DE-only") == Compiled{false, true, false, true});
  CHECK(switched("LS+DE-only,LS+DS+E-only") == Compiled{false, true, true, true});
  CHECK(switched("no-mirrored") == Compiled{true, true, false, true});
  CHECK(switched("no-direct") == Compiled{true, true, true, true});
  CHECK(switched("no-glossy") == Compiled{true, true, true, false});  // there is nothing glossy to leave out
}

TEST_CASE("the plan of a scene, as data") {
  const gmis_test::FurnaceScene<float> scene(.5F, 1.0F, 4);
  const gmis::RenderSettings settings;
  const gmis::Plan plan = gmis::plan_for(gmis::effects_of(scene), settings.max_depth, settings.path_classes);
  for (const gmis::TechniquePlan& technique : plan.techniques)
    std::printf("%s: %s\n", technique.is_on ? "on" : "off", std::string(gmis::sentence_of(technique.rule)).c_str());
  const bool traces_light = gmis::dispatch(plan, []<class Integrator>() { return Integrator::traces_light; });
  CHECK(traces_light);  // it does not say what it has
}
