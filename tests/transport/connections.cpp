#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "gmis/transport/allocation/engines_with_pilot.hpp"
#include "gmis/transport/allocation/render_engine.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/ways.hpp"

// Connections from the cache of all trees and the paired form make the furnace's light, (1 −
// a^D)/(1 − a). Each mean is off the truth by at most Student's limit (`Measured::chance`) and
// 0.1 %; a standard error is at most 0.2 %, so that 1 % shows.

namespace {

using namespace gmis;
namespace ways = gmis_test::ways;

// The sanitizers look at how memory is used, and take twenty times as long: there a tenth of the
// iterations is enough, and the standard errors may be larger.
#if defined(__SANITIZE_ADDRESS__)
constexpr int fewer = 10;
#else
constexpr int fewer = 1;
#endif
using Furnace = gmis_test::FurnaceScene<float>;

struct Measured {
  double mean, standard_error;
  double chance;  ///< what chance may make of the difference between the mean and what it estimates
  Counters counters;
  SampleCounts counts;
};

// Bpt with four numbers of connections and trees, connections alone in two forms, and what a pilot
// chooses.
gmis_test::Family family(1e-3, 7);

/// A mean with its standard error and, by Student's t, its limit of chance: a false alarm of all
/// comparisons together in a thousandth of the seeds.
Measured measured(double sum, double squares, int iterations, const Counters& counters, const SampleCounts& counts) {
  const double mean = sum / iterations;
  const double error = std::sqrt(std::max(0.0, squares / iterations - mean * mean) / (iterations - 1));
  return {mean, error, family.limit(static_cast<std::size_t>(iterations)) * error, counters, counts};
}

template <class I>
Measured render(const RenderSettings& settings, int wanted) {
  const int iterations = std::max(2, wanted / fewer);
  const Furnace scene(0.7F, 1.0F, 16, 2);
  typename I::template Engine<Furnace> engine(scene, I::settings(settings));
  SerialExecutor executor;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    for (const float value : engine.frame()) mean += static_cast<double>(value);
    mean /= static_cast<double>(engine.frame().size());
    sum += mean;
    squares += mean * mean;
  }
  return measured(sum, squares, iterations, engine.counters(), engine.counts());
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

void check(const Measured& measured) {
  const double truth = (1.0 - std::pow(0.7, 6)) / (1.0 - 0.7);
  CAPTURE(truth, measured.mean, measured.standard_error);
  CHECK(std::abs(measured.mean - truth) < measured.chance + 1e-3 * truth);
  CHECK(measured.standard_error < 2e-3 * std::sqrt(fewer) * truth);
}

/// The mean of the connections of two light and two camera vertices without their weight.
Measured connections_alone(const RenderSettings& settings, int wanted) {
  const int iterations = std::max(2, wanted / fewer);
  const Furnace scene(0.7F, 1.0F, 16, 1);
  Engine<Furnace> engine(scene, ways::Bpt::settings(settings));
  engine.keep_contributions(true);
  SerialExecutor executor;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    engine.for_each_contribution([&](const Contribution<float>& c) {
      if (c.id.technique == Technique::connect && c.id.s == 2 && c.id.t == 2) mean += static_cast<double>(c.value);
    });
    mean /= static_cast<double>(engine.frame().size());
    sum += mean;
    squares += mean * mean;
  }
  return measured(sum, squares, iterations, engine.counters(), engine.counts());
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
      check(render<ways::Bpt>(settings_with(connections), 300));
    }
  }
  for (const int connections : {0, 8}) DYNAMIC_SECTION("connections alone, " << connections) {
      // Within a sphere the geometry term is the same for all pairs of points, so that the spread
      // is small.
      const Measured alone = connections_alone(settings_with(connections), 300);
      const double truth = 0.7 * 0.7;
      CAPTURE(alone.mean, alone.standard_error, truth);
      CHECK(std::abs(alone.mean - truth) < alone.chance + 1e-5);
      CHECK(alone.standard_error < 2e-3 * std::sqrt(fewer) * truth);
    }
  SECTION("few trees, each used by many pixels") {
    RenderSettings settings = settings_with(2);
    settings.counts.light_paths = 0.25;
    check(render<ways::Bpt>(settings, 400));
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
  const int iterations = std::max(4, 250 / fewer);
  double sum = 0.0, squares = 0.0;
  std::optional<SampleCounts> chosen;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0.0;
    for (const float value : engine.engine().frame()) mean += static_cast<double>(value);
    mean /= static_cast<double>(engine.engine().frame().size());
    sum += mean;
    squares += mean * mean;
    if (!chosen) chosen = engine.engine().counts();
    REQUIRE(engine.engine().counts() == *chosen);
  }
  REQUIRE(engine.choice() != nullptr);
  CHECK(engine.choice()->pilot_iterations == 4);
  CHECK(engine.choice()->forecasts[engine.choice()->chosen.value()].counts == *chosen);
  check(measured(sum, squares, iterations, engine.counters(), engine.engine().counts()));
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
