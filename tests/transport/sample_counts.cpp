#include "gmis/transport/state/sample_counts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "gmis/transport/plan/effect_switches.hpp"
#include "gmis/transport/plan/plan.hpp"
#include "gmis/transport/splitting/gmis_engines.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/ways.hpp"

namespace {

using gmis_test::message_of;

using Scene = gmis_test::FurnaceScene<float>;
using gmis::Technique;
using gmis_test::message_of;

gmis::SampleCounts counts_for(const gmis::Plan& plan) {
  return gmis::integrators::vcm.only([&](Technique technique) { return plan.has(technique); });
}

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = 5;
  result.radius = 0.1;
  result.seed = gmis_test::seed(17);
  return result;
}

}  // namespace

TEST_CASE("A plan's techniques are those of the counts, and no others") {
  gmis::Effects effects;
  effects.diffuse = effects.area_lights = true;
  CHECK(counts_for(gmis::plan_for(effects, 2)) == gmis::integrators::pt);
  CHECK(counts_for(gmis::plan_for(effects, 8)) == gmis::integrators::bpt);
  effects.specular_reflection = true;
  CHECK(counts_for(gmis::plan_for(effects, 8)) == gmis::integrators::vcm);
  const auto switched = [&](const char* list) {
    return counts_for(gmis::plan_for(effects, 8, gmis::switched_effects(list).classes));
  };
  CHECK(switched("direct-only") == gmis::integrators::pt);
  CHECK(switched("LDE-only,LS+DE-only") == gmis::integrators::pt_lt);
  // No next event makes light that a mirror casts.
  CHECK(switched("LS+DE-only,LS+DS+E-only") ==
        gmis::integrators::pt_lt_pm.only([](Technique t) { return t != Technique::next_event; }));
  CHECK(switched("no-mirrored") == gmis::integrators::bpt);
  // A light that no ray can meet.
  effects.area_lights = false;
  effects.point_lights = true;
  CHECK_FALSE(counts_for(gmis::plan_for(effects, 8)).emitter_hits);
  // Nothing that any technique can make.
  effects.point_lights = false;
  const gmis::SampleCounts nothing = counts_for(gmis::plan_for(effects, 8));
  for (const Technique technique : gmis::all_techniques) CHECK_FALSE(nothing.has(technique));
  CHECK_FALSE((nothing.traces_light() || nothing.traces_camera()));
}

TEST_CASE("A technique without light trees is off") {
  gmis::SampleCounts counts = gmis::integrators::vcm;
  counts.light_paths = 0.0;
  for (const Technique technique : {Technique::connect, Technique::splat, Technique::merge})
    CHECK_FALSE(counts.has(technique));
  CHECK_FALSE(counts.traces_light());
}

TEST_CASE("Connections with the paired tree are connections, and none of them is drawn") {
  gmis::SampleCounts counts = gmis::integrators::vcm;
  CHECK(counts.draws_connections());
  counts.connects_paired_tree = true;
  CHECK(counts.has(Technique::connect));
  CHECK_FALSE(counts.draws_connections());
}

TEST_CASE("Splats alone make a picture") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  gmis::RenderSettings alone = settings();
  alone.counts = gmis::integrators::lt.only([](Technique technique) { return technique == Technique::splat; });
  gmis::Engine<Scene> engine(scene, alone);
  engine.iterate(executor);
  float sum = 0.0F;
  for (const float value : engine.frame()) sum += value;
  CHECK(engine.counters().splats > 0);
  CHECK(sum > 0.0F);
}

TEST_CASE("What is off is not done: its counters are 0") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  const auto counted = [&](const gmis::SampleCounts& counts) {
    gmis::RenderSettings off = settings();
    off.counts = counts;
    gmis::Engine<Scene> engine(scene, off);
    engine.iterate(executor);
    return engine.counters();
  };
  using namespace gmis::integrators;
  CHECK(counted(vcm).merges > 0);
  for (const gmis::SampleCounts& counts : {pt, lt, pt_lt, pt_lt_pm, bpt, ppm, bpm, vcm}) {
    const gmis::Counters made = counted(counts);
    const auto is_off = [&](Technique technique, std::uint64_t count) {
      CHECK((counts.has(technique) || count == 0));
      CHECK((!counts.has(technique) || count > 0));
    };
    is_off(Technique::connect, made.connections);
    is_off(Technique::splat, made.splats);
    is_off(Technique::splat, made.projections);
    CHECK(made.projections >= made.splats);
    is_off(Technique::merge, made.merge_queries);
    CHECK((made.photons_stored > 0) == counts.stores_light_vertices());
    CHECK((made.grids_built > 0) == counts.has(Technique::merge));
    CHECK((made.light_subpaths > 0) == counts.traces_light());
    CHECK((made.shadow_rays > 0) ==
          (counts.next_events || counts.has(Technique::connect) || counts.has(Technique::splat)));
  }
}

TEST_CASE("Without any technique nothing is traced, and the picture is black") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  gmis::RenderSettings empty = settings();
  empty.counts = empty.counts.only([](Technique) { return false; });
  gmis::RenderEngine<float> engine(gmis::engines_of(scene), empty);
  for (int i = 0; i < 2; ++i) engine.iterate(executor);
  CHECK(engine.counters().rays == 0);
  CHECK(engine.counters().camera_paths == 0);
  for (const float value : engine.engine().frame()) CHECK(value == 0.0F);
}

TEST_CASE("Settings that mean nothing are refused, with what to change") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  const auto refused = [&](const std::function<void(gmis::RenderSettings&)>& change) {
    gmis::RenderSettings wrong = settings();
    change(wrong);
    return message_of([&] { gmis::Engine<Scene> engine(scene, wrong); });
  };
  using Settings = gmis::RenderSettings;
  CHECK(refused([](Settings&) {}).empty());
  CHECK(refused([](Settings& s) { s.radius = 0.0; }).find("leave the radius unset") != std::string::npos);
  CHECK(refused([](Settings& s) { s.radius = -1.0; }).find("radius") != std::string::npos);
  CHECK(refused([](Settings& s) { s.radius = std::numeric_limits<double>::infinity(); }).find("finite") !=
        std::string::npos);
  CHECK(refused([](Settings& s) { s.radius = 0.0, s.counts.merges = false; }).empty());
  CHECK(refused([](Settings& s) { s.radius.reset(); }).empty());
  CHECK(refused([](Settings& s) { s.max_depth = 257; }).find("max_depth") != std::string::npos);
  CHECK(refused([](Settings& s) { s.max_depth = 0; }).find("max_depth") != std::string::npos);
  CHECK(refused([](Settings& s) { s.max_depth = -1; }).find("max_depth") != std::string::npos);
  CHECK(refused([](Settings& s) { s.max_depth = 1; }).empty());
  CHECK(refused([](Settings& s) { s.max_depth = 256; }).empty());
  CHECK(refused([](Settings& s) { s.counts.radius_factor = 0.0; }).find("radius_factor") != std::string::npos);
  constexpr double inf = std::numeric_limits<double>::infinity();
  CHECK(refused([](Settings& s) { s.counts.radius_factor = inf; }).find("radius_factor") != std::string::npos);
  CHECK(refused([](Settings& s) { s.radius = 1e20; }).find("too large") != std::string::npos);  // 1e40 is no float
  CHECK(refused([](Settings& s) { s.radius.reset(), s.counts.radius_factor = 1e20; }).find("too large") !=
        std::string::npos);
  CHECK(refused([](Settings& s) { s.radius = 1e20, s.counts.merges = false; }).empty());
  CHECK(refused([](Settings& s) { s.emission = gmis::Emission::learned; }).find("cannot be guided") !=
        std::string::npos);
  CHECK(refused([](Settings& s) { s.counts.light_paths = 4294967296.0 / 144; }).find("light_paths") !=
        std::string::npos);
  CHECK(refused([](Settings& s) { s.counts.light_paths = -1.0; }).find("light_paths") != std::string::npos);
  CHECK(refused([](Settings& s) { s.counts.connections = -2; }).find("connections") != std::string::npos);
  CHECK(refused([](Settings& s) { s.alpha = 0.0; }).find("alpha") != std::string::npos);
  CHECK(refused([](Settings& s) { s.alpha = 1.01; }).find("alpha") != std::string::npos);
  const Scene empty(0.7F, 1.0F, 0, 2);
  CHECK(message_of([&] { gmis::Engine<Scene> engine(empty, settings()); }).find("no pixels") != std::string::npos);
  gmis::RenderSettings sobol = settings();
  sobol.counts = gmis::integrators::pt;
  sobol.sampler = gmis::Sampler::sobol;
  CHECK(message_of([&] { gmis::PathTracer<Scene> engine(scene, sobol); }).empty());
  CHECK(message_of([&] { gmis::PathTracer<Scene, gmis::Philox> engine(scene, sobol); }).find("SampleNumbers") !=
        std::string::npos);

  CHECK(message_of([&] { gmis::PathTracer<Scene> engine(scene, settings()); }).find("integrators::pt") !=
        std::string::npos);
  const auto trees_refused = [&](const gmis::GmisSampler& sampler) {
    return message_of([&] { gmis::Engine<Scene, gmis::SplitTrees> engine(scene, settings(), {}, sampler); });
  };
  CHECK(trees_refused({}).empty());
  CHECK(trees_refused({.budget = 1 << 22}).find("GmisSampler::budget") != std::string::npos);
  CHECK(trees_refused({.budget = 0}).find("GmisSampler::budget") != std::string::npos);

  const std::vector<gmis::SampleCounts> two{{1.0, 1, true, true}, {0.5, 2, true, true}};
  for (const auto& engines : {gmis::engines_of(scene), gmis::gmis_engines(scene, {})})
    CHECK(message_of([&] {
            gmis::RenderEngine<float> engine(engines, settings(), two, 64);
          }).find("engines_with_pilot") != std::string::npos);
  const auto pilot_refused = [&](const gmis::SampleCounts& counts) {
    gmis::RenderSettings of_pilot = settings();
    of_pilot.counts = counts;
    return message_of([&] { gmis::RenderPilot<Scene> pilot(scene, of_pilot, two, 64); });
  };
  CHECK(pilot_refused({1.0, 1, true, true}).empty());
  CHECK(pilot_refused({1.0, 1, true, false}).find("a candidate has a technique") != std::string::npos);
  CHECK(pilot_refused(gmis::integrators::pt).find("a candidate has a technique") != std::string::npos);
}

TEST_CASE("The merging radius that nobody sets follows the picture") {
  const Scene coarse(0.7F, 1.0F, 12, 1), fine(0.7F, 1.0F, 24, 1);
  gmis::RenderSettings unset = settings();
  unset.radius.reset();
  const auto radius_of = [&](const Scene& scene, const std::optional<gmis::PixelBounds>& crop = {}) {
    return gmis::Engine<Scene>(scene, unset, crop).first_radius();
  };
  CHECK(radius_of(coarse) == Approx(2 * radius_of(fine)).epsilon(0.1));
  CHECK(radius_of(coarse) == radius_of(coarse, gmis::PixelBounds{{0, 0}, {3, 2}}));
  // Seen from the centre, all of the furnace's sphere is at distance 1. The image plane there is
  // 1.5 wide: the solid angle of a pixel is (1.5 / 12)² cos³.
  std::vector<double> widths;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) {
      const double u = 1.5 * ((x + 0.5) / 12 - 0.5), v = 1.5 * ((y + 0.5) / 12 - 0.5);
      widths.push_back(1.5 / 12 * std::pow(1 + u * u + v * v, -0.75));
    }
  std::nth_element(widths.begin(), widths.begin() + 72, widths.end());
  const Scene from_centre(0.7F, 1.0F, 12, 1, gmis::Vec3<float>(0.0F));
  CHECK(radius_of(from_centre) == Approx(0.4 * widths[72]).epsilon(1e-5));
}

TEST_CASE("What is off is not weighted: a technique that alone can make a path has the weight 1") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  for (const Technique alone : gmis::all_techniques) {
    gmis::RenderSettings one = settings();
    one.counts = one.counts.only([&](Technique technique) { return technique == alone; });
    gmis::Engine<Scene> engine(scene, one);
    engine.keep_contributions(true);
    engine.iterate(executor);
    int made = 0, shared = 0;
    engine.for_each_contribution([&](const gmis::Contribution<float>& c) {
      // Longer paths can be merged, and connected, at several of their vertices.
      if (alone == Technique::merge && c.id.s + c.id.t > 4) return;
      if (alone == Technique::connect && c.id.s + c.id.t > 4) return;
      ++made;
      shared += std::abs(c.weight - 1.0F) > 1e-5F;
    });
    CAPTURE(static_cast<int>(alone));
    CHECK(made > 0);
    CHECK(shared == 0);
  }
}

TEST_CASE("Light trees end where no path that is wanted can come of them") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  gmis::RenderSettings direct = settings();
  direct.path_classes = gmis::switched_effects("direct-only").classes;
  gmis::Engine<Scene> engine(scene, direct);
  engine.iterate(executor);
  // A tree is told by what it scattered at: the second vertex is found, and neither kept nor left.
  CHECK(engine.light_work().light_subpaths == 144);
  CHECK(engine.light_work().rays <= 2 * 144);
  CHECK(engine.counters().photons_stored <= 144);
  CHECK(engine.counters().photons_stored > 0);
}

TEST_CASE("The census of light trees does not depend on what is done with them") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  const auto vertices = [&](const gmis::SampleCounts& counts) {
    gmis::RenderSettings with = settings();
    with.counts = counts;
    gmis::Engine<Scene> engine(scene, with);
    engine.iterate(executor);
    return engine.vertices_per_tree();
  };
  gmis::SampleCounts connections = gmis::integrators::bpt;
  connections.splats = false;
  CHECK(vertices(connections) > 1.0);
  CHECK(vertices(connections) == vertices(gmis::integrators::vcm));
}

TEST_CASE("After its pilot a run is one with the chosen counts, and has nothing of the pilot's samples") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  gmis::SerialExecutor executor;
  const gmis::RenderSettings asked = settings();
  const std::vector<gmis::SampleCounts> candidates{{1.0, 1, true, true}, {0.5, 2, true, true}};
  gmis::RenderEngine<float> run(gmis::engines_with_pilot(scene), asked, candidates, 64);
  const std::uint32_t pilot = gmis::pilot_iterations_for(64);
  // The pilot merges in the mean disk of the run.
  CHECK(run.engine().first_radius() == Approx(*asked.radius * std::sqrt(gmis::mean_disk(asked.alpha, 64))));
  CHECK(run.choice() == nullptr);
  run.iterate(executor);
  REQUIRE(run.choice() != nullptr);
  CHECK(run.choice()->pilot_iterations == pilot);
  CHECK(run.counters().camera_paths == (pilot + 1) * 144);
  gmis::RenderSettings chosen = asked;
  chosen.counts = run.engine().counts();
  gmis::Engine<Scene> other(scene, chosen);
  other.iterate(executor);
  const auto frame = run.engine().frame();
  CHECK(std::equal(other.frame().begin(), other.frame().end(), frame.begin(), frame.end()));
  CHECK(run.counters().contributions == other.counters().contributions);
  CHECK(run.counters().rays > other.counters().rays);
  // A choice that is made by the numbers of the picture would be biased.
  gmis::RenderPilot<Scene> same_numbers(scene, asked, candidates, 64);
  for (std::uint32_t i = 0; i < pilot; ++i) same_numbers.iterate(executor);
  CHECK(same_numbers.forecasts()[0].variance != run.choice()->forecasts[0].variance);
}

TEST_CASE("One candidate for the counts is taken without a pilot, and none leaves those of the settings") {
  const Scene scene(0.7F, 1.0F, 12, 2);
  const gmis::SampleCounts candidate{0.5, 2, true, false};
  const gmis::RenderEngine<float> one(gmis::engines_of(scene), settings(), {candidate}, 64);
  const gmis::RenderEngine<float> none(gmis::engines_of(scene), settings(), {}, 64);
  CHECK(one.engine().counts() == candidate);
  CHECK(none.engine().counts() == settings().counts);
  CHECK((one.choice() == nullptr && none.choice() == nullptr));
}

TEST_CASE("A pilot has two iterations for each hundred of the run, at least 2 and at most 16") {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted{
      {0, 2}, {99, 2}, {100, 2}, {199, 2}, {200, 4}, {799, 14}, {800, 16}, {899, 16}, {900, 16}, {100'000, 16}};
  for (const auto& [run, pilot] : wanted) {
    CAPTURE(run);
    CHECK(gmis::pilot_iterations_for(run) == pilot);
  }
}

TEST_CASE("A pilot takes the pixels of its crop, not those of the frame, within one radius") {
  // The whole frame has enough pixels that a pilot would take an eighth of them.
  const Scene scene(0.7F, 1.0F, 260, 1);
  gmis::SerialExecutor executor;
  gmis::RenderSettings direct = settings();
  direct.max_depth = 2;
  const gmis::PixelBounds row{{0, 7}, {8, 8}};
  gmis::RenderPilot<Scene> pilot(scene, direct, {{1.0, 1, true, true}, {0.5, 2, true, true}}, 2, row);
  for (int i = 0; i < 2; ++i) pilot.iterate(executor);
  CHECK(pilot.has_seen_pixels());
  CHECK(pilot.engine().counters().camera_paths == 2 * 8);
  CHECK(pilot.engine().merge_radius(2) == pilot.engine().first_radius());
}

TEST_CASE("the plan of a scene, as data") {
  const gmis_test::FurnaceScene<float> scene(.5F, 1.0F, 4);
  gmis::RenderSettings settings;
  const gmis::Plan plan = gmis::plan_for(gmis::effects_of(scene), settings.max_depth);
  for (const gmis::TechniquePlan& technique : plan.techniques)
    std::printf("%s: %s\n", technique.is_on ? "on" : "off", std::string(gmis::sentence_of(technique.rule)).c_str());
  settings.counts = gmis::integrators::vcm.only([&](gmis::Technique technique) { return plan.has(technique); });
  gmis::RenderEngine<float> engine(gmis::engines_of(scene), settings);
  CHECK(settings.counts.traces_light());  // the scene does not say what it has
}
