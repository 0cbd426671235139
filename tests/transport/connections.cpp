#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "gmis/scene.hpp"
#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "transport/built_in_engines.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/ways.hpp"

// Connections from the cache of all trees and the paired form make the furnace's light, (1 −
// a^D)/(1 − a). Each mean is off the truth by at most Student's limit (`chance`) and
// 0.1 %; a standard error is at most 0.2 %, so that 1 % shows.

namespace {

using namespace gmis;
namespace ways = gmis_test::ways;
using gmis_test::Series;

using Furnace = gmis_test::FurnaceScene<float>;

// Bpt with four numbers of connections and trees, connections alone in two forms, and what a pilot
// chooses.
gmis_test::Family family(1e-3, 7);

/// Limit of chance, by Student's t, for the difference between a mean and what it estimates: a
/// false alarm of all comparisons together in a thousandth of the seeds.
double chance(const Series& means) {
  return family.limit(means.count()) * means.standard_error();
}

/// 0 connections: those of the paired tree.
RenderSettings settings_with(int connections) {
  RenderSettings settings;
  settings.max_depth = 6;
  settings.radius = 0.02;
  settings.counts.connections = std::max(1, connections);
  settings.counts.connects_paired_tree = connections == 0;
  settings.seed = gmis_test::seed(25);
  return settings;
}

void check(const Series& means) {
  const double truth = (1.0 - std::pow(0.7, 6)) / (1.0 - 0.7);
  CAPTURE(truth, means.mean(), means.standard_error());
  const double by_chance = chance(means);
  CHECK(std::abs(means.mean() - truth) < by_chance + 1e-3 * truth);
  CHECK(means.standard_error() < 2e-3 * truth);
}

void check_bpt(const RenderSettings& settings, int iterations) {
  const Furnace scene(0.7F, 1.0F, 16, 2);
  Engine<Furnace> engine(scene, ways::Bpt::settings(settings));
  check(gmis_test::means_of_iterations(engine, iterations));
}

/// The mean of the connections of two light and two camera vertices without their weight.
Series connections_alone(const RenderSettings& settings, int iterations) {
  const Furnace scene(0.7F, 1.0F, 16, 1);
  Engine<Furnace> engine(scene, ways::Bpt::settings(settings));
  engine.keep_contributions(true);
  SerialExecutor executor;
  Series means;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    engine.for_each_contribution([&](const Contribution<float>& c) {
      if (c.id.technique == Technique::connect && c.id.s == 2 && c.id.t == 2) mean += static_cast<double>(c.value);
    });
    means.add(mean / static_cast<double>(engine.frame().size()));
  }
  return means;
}

}  // namespace

TEST_CASE("visibility queries are counted for those who ask") {
  // In the furnace all is visible, and what is black is not asked for: a query for every
  // contribution.
  const Furnace scene(0.7F, 1.0F, 16, 1);
  Engine<Furnace> engine(scene, ways::Bpt::settings(settings_with(2)));
  engine.keep_contributions(true);
  SerialExecutor executor;
  engine.iterate(executor);
  std::uint64_t connections = 0, splats = 0, next_events = 0;
  engine.for_each_contribution([&](const Contribution<float>& c) {
    connections += c.id.technique == Technique::connect ? 1 : 0;
    splats += c.id.technique == Technique::splat ? 1 : 0;
    next_events += c.id.technique == Technique::next_event ? 1 : 0;
  });
  CHECK(connections > 100);
  CHECK(engine.counters().connection_rays == connections);
  CHECK(engine.light_work().shadow_rays == splats);
  CHECK(engine.counters().shadow_rays == connections + splats + next_events);
}

TEST_CASE("any number of connections from the cache makes the same light as the paired tree") {
  for (const int connections : {0, 1, 3}) {
    DYNAMIC_SECTION("bpt, connections " << connections) {
      check_bpt(settings_with(connections), 300);
    }
  }
  for (const int connections : {0, 8}) DYNAMIC_SECTION("connections alone, " << connections) {
      // Within a sphere the geometry term is the same for all pairs of points, so that the spread
      // is small.
      const Series alone = connections_alone(settings_with(connections), 300);
      const double truth = 0.7 * 0.7, by_chance = chance(alone);
      CAPTURE(alone.mean(), alone.standard_error(), truth);
      CHECK(std::abs(alone.mean() - truth) < by_chance + 1e-5);
      CHECK(alone.standard_error() < 2e-3 * truth);
    }
  SECTION("few trees, each used by many pixels") {
    RenderSettings settings = settings_with(2);
    settings.counts.light_paths = 0.25;
    check_bpt(settings, 400);
  }
}

TEST_CASE("a camera vertex is connected as often as asked for, however large the trees are") {
  RenderSettings settings = settings_with(2);
  settings.counts.light_paths = 3.0;
  const Furnace scene(0.7F, 1.0F, 16, 1);
  Engine<Furnace> engine(scene, ways::Bpt::settings(settings));
  SerialExecutor executor;
  for (int i = 0; i < 2; ++i) engine.iterate(executor);
  // Each ray of a camera subpath ends in a vertex, which makes two attempts; some are too deep.
  const std::uint64_t vertices = engine.counters().rays - engine.light_work().rays;
  CHECK(engine.counters().connections <= 2 * vertices);
  CHECK(engine.counters().connections > vertices);
  CHECK(engine.counts().connections == 2);
}

TEST_CASE("counts that a pilot chooses leave the light as it is, and stay as they are") {
  RenderSettings settings = settings_with(1);
  const Furnace scene(0.7F, 1.0F, 16, 2);
  RenderEngine<float> engine(engines_with_pilot(scene), settings, all_candidates(), 250);
  SerialExecutor executor;
  const int iterations = 250;
  Series means;
  std::optional<SampleCounts> chosen;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    means.add(gmis_test::mean_of_pixels(engine.engine().frame()));
    if (!chosen) chosen = engine.engine().counts();
    REQUIRE(engine.engine().counts() == *chosen);
  }
  REQUIRE(engine.choice() != nullptr);
  CHECK(engine.choice()->pilot_iterations == 4);
  CHECK(engine.choice()->forecasts[engine.choice()->chosen.value()].counts == *chosen);
  check(means);
}

TEST_CASE("a pilot that sees no pixel chooses nothing") {
  const Furnace scene(0.7F, 1.0F, 16, 2);
  const PixelBounds empty{{5, 5}, {5, 9}};
  RenderEngine<float> engine(engines_with_pilot(scene), settings_with(1), all_candidates(), 64, empty);
  SerialExecutor executor;
  for (int i = 0; i < 3; ++i) engine.iterate(executor);
  REQUIRE(engine.choice() != nullptr);
  CHECK_FALSE(engine.choice()->chosen.has_value());
  CHECK(engine.engine().counts() == settings_with(1).counts);
}

TEST_CASE("trees that store nothing in the census leave connections their light") {
  // Two balls that light each other, and a lamp so far away that one tree in thousands meets them:
  // the 4,096 trees that tell the number of light vertices often have none.
  using Scene = scene::BvhScene<float>;
  scene::SceneBuilder<float> builder;
  const auto white = builder.add_material(scene::make_diffuse({0.7, 0.7, 0.7}));
  builder.add_sphere({-1.05, 0, 0}, 1, white);
  builder.add_sphere({1.05, 0, 0}, 1, white);
  builder.add_point_light({0, 60, 0}, {9e3, 9e3, 9e3});
  builder.set_camera(scene::look_at({0, 0, -6}, {0, 0, 0}, {0, 1, 0}, 40, {32, 32}));
  const Scene built = builder.build();
  SerialExecutor executor;
  int without_vertices = 0;
  for (std::uint64_t k = 0; k < 24; ++k) {
    RenderSettings settings;
    settings.counts = integrators::bpt;
    settings.counts.next_events = settings.counts.splats = false;
    settings.counts.light_paths = 32;
    settings.max_depth = 3;
    settings.seed = gmis_test::seed(26) + k;
    Engine<Scene> engine(built, settings);
    double light = 0;
    for (int i = 0; i < 20; ++i) {
      engine.iterate(executor);
      for (const auto& pixel : engine.frame()) light += static_cast<double>(pixel.x);
    }
    // 655,360 trees store a hundred vertices in the mean: none has a chance below 1e-40.
    if (engine.vertices_per_tree() == 0.0) {
      ++without_vertices;
      CHECK(light > 0);
    }
  }
  CHECK(without_vertices > 0);  // more than half of the seeds: false in one of 10^8 runs
}
