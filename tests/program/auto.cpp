#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/transport/allocation/pilot.hpp"
#include "program/block_statistics.hpp"
#include "support/build_scene.hpp"
#include "support/catch.hpp"
#include "support/choices.hpp"
#include "support/measured_variance.hpp"
#include "support/pbrt/reader.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"

// `--integrator auto`: what the pilot forecasts against what renderings then have, and that nothing
// is missing in scenes that tempt it.

using namespace gmis::tools;
using gmis::Forecast;
using gmis::SampleCounts;
using Spectrum = SceneSpectrum;

namespace {

const std::string ground = R"(
Material "diffuse" "rgb reflectance" [ .6 .6 .6 ]
Shape "bilinearmesh" "point3 P" [ -3 0 -3  3 0 -3  -3 0 3  3 0 3 ]
)";

std::unique_ptr<BuiltScene> scene_of(const std::string& world) {
  Diagnostics diagnostics;
  const std::string text = R"(
LookAt 0 4.5 -3  0 .3 0  0 1 0
Camera "perspective" "float fov" 28
Film "rgb" "integer xresolution" 24 "integer yresolution" 24
WorldBegin
)" + ground + world;
  const SceneDescription description = read_pbrt_text(text, "test", GMIS_SCENE_FOLDER, diagnostics);
  return build_scene(description, diagnostics);
}

RenderRequest request_for(const BuiltScene& scene, IntegratorChoice integrator = IntegratorChoice::automatic,
                          Options options = {}) {
  RenderRequest request;
  request.integrator = options.integrator = integrator;
  request.split = options.split = SplitChoice::none;
  request.expected_iterations = 64;
  request.settings.seed = gmis_test::seed(5);
  request.settings.max_depth = 6;
  request.settings.radius = 0.01 * scene.half_diagonal();
  set_counts(request, options, scene);
  return request;
}

const std::string lamp = R"(
AttributeBegin
  Material "diffuse" "rgb reflectance" [ 0 0 0 ]
  AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
  Translate 2 3 .5
  Shape "bilinearmesh" "point3 P" [ -.5 0 -.5  .5 0 -.5  -.5 0 .5  .5 0 .5 ]
AttributeEnd
)";
const std::string point_light = R"(LightSource "point" "rgb I" [ 9 9 9 ] "point3 from" [ 1.2 3.5 .8 ]
)";
const std::string glass_ball = R"(
AttributeBegin
  Material "dielectric" "float eta" 1.5
  Translate 0 .8 0
  Shape "sphere" "float radius" .7
AttributeEnd
)";
const std::string diffuse_ball = R"(
AttributeBegin
  Translate .4 .8 .3
  Shape "sphere" "float radius" .7
AttributeEnd
)";

}  // namespace

TEST_CASE("The pilot's picture is that of vcm with its counts and its radius", "[auto]") {
  const auto scene = scene_of(lamp + glass_ball);
  ThreadedExecutor executor(1);
  RenderRequest request = request_for(*scene, IntegratorChoice::vcm);
  gmis::RenderPilot<BuiltScene::SceneType> pilot(scene->scene(), request.settings, gmis::all_candidates(), 100);
  request.settings.counts.connections = 2;
  request.settings.counts.light_paths = 0.125;
  // The mean disk of 100 iterations.
  double disk = 0;
  for (int i = 1; i <= 100; ++i) disk += std::pow(i, request.settings.alpha - 1) / 100;
  *request.settings.radius *= std::sqrt(disk);
  request.settings.alpha = 1;
  gmis::Engine<BuiltScene::SceneType> vcm(scene->scene(), request.settings);
  for (int i = 0; i < 2; ++i) {
    vcm.iterate(executor);
    pilot.iterate(executor);
    const auto expected = vcm.frame(), frame = pilot.engine().frame();
    double worst = 0;
    for (std::size_t p = 0; p < frame.size(); ++p)
      worst =
          std::max(worst, static_cast<double>(std::abs(gmis::mean_channel(frame[p]) - gmis::mean_channel(expected[p])) /
                                              (gmis::mean_channel(expected[p]) + 0.01F)));
    CHECK(worst < 1e-3);
  }
}

TEST_CASE("Forecasts of variance and cost are what renderings then have", "[auto][long]") {
  // No fireflies here: a variance with a heavy tail is hard to measure. One radius for all of them.
  // Several pilots, so that the spread of their forecasts is known. Splitting is not among the
  // candidates: a pilot splits at a fixed quarter of the pixels, which stand for all only where
  // pixels are alike (test_transport_pilot).
  const auto scene = scene_of(lamp + diffuse_ball);
  ThreadedExecutor executor(1);
  RenderRequest request = request_for(*scene);
  request.settings.alpha = 1.0;
  const std::vector<SampleCounts> some{{1.0, 1, true, true},  {0.0, 0, false, false}, {0.25, 0, true, false},
                                       {0.5, 1, true, false}, {1.0, 4, true, false},  {0.25, 0, true, true},
                                       {2.0, 2, true, true}};
  request.settings.counts = {};  // all techniques
  gmis::RenderSettings settings = request.settings;
  constexpr std::size_t batches = 25;
  constexpr int iterations = 40;
  std::vector<gmis_test::MeasuredVariance> all;
  std::vector<double> cost, vertex_variance;
  request.settings.seed = gmis_test::seed(99);
  for (const SampleCounts& candidate : some) {
    request.settings.counts = candidate;
    request.candidates.clear();
    const auto source = start(*scene, request);
    double vertices = 0, squares = 0;
    std::uint64_t stored = 0;
    all.emplace_back(batches, iterations, [&] {
      source->iterate(executor);
      const auto added = static_cast<double>(source->counters().photons_stored - stored);
      stored = source->counters().photons_stored;
      vertices += added;
      squares += added * added;
      return source->engine().frame();
    });
    constexpr double frames = batches * iterations;
    cost.push_back(gmis::cost_of(source->counters()) / frames);
    vertex_variance.push_back(vertices > 0 ? squares * frames / (vertices * vertices) - 1 : 0.0);
  }
  const gmis::OperationCosts costs;
  std::vector<gmis_test::Series> forecast(some.size());
  std::vector<double> forecast_cost(some.size());
  for (std::size_t batch = 0; batch < batches; ++batch) {
    ++settings.seed;
    gmis::RenderPilot<BuiltScene::SceneType> pilot(scene->scene(), settings, some, 64);
    pilot.compare_with(all[0].mean());
    for (int i = 0; i < 8; ++i) pilot.iterate(executor);
    const std::vector<Forecast> forecasts = pilot.forecasts(costs);
    for (std::size_t c = 0; c < some.size(); ++c) {
      forecast[c].add(forecasts[c].variance);
      forecast_cost[c] += forecasts[c].cost / batches;
      CHECK(forecasts[c].missing_share == 0.0);
    }
  }
  // False alarms 1e-3 for all candidates together; Welch's t has at least `batches` − 1 degrees of
  // freedom.
  const double t = gmis::student_t_quantile(1 - gmis::sidak_level(1e-3, some.size()) / 2, batches - 1);
  for (std::size_t c = 0; c < some.size(); ++c) {
    INFO(some[c].light_paths << " light paths, " << some[c].connections << " connections, merging " << some[c].merges);
    const gmis_test::RelativeVariance own = all[c].relative_to(all[0].mean());
    const double variance = forecast[c].mean(), pilot_error = forecast[c].standard_error() / variance;
    // A forecast takes the mean number of light vertices for that of each iteration
    // (test_transport_pilot).
    const double model = some[c].connections > 0 ? vertex_variance[c] : 0.0;
    const double limit = t * std::hypot(own.relative_error, pilot_error) + model;
    CAPTURE(variance / own.value, own.relative_error, pilot_error, model, limit);
    CHECK(std::abs(variance / own.value - 1) < limit);
    CHECK(limit < 0.12);  // so that it says something
    CHECK(std::abs(forecast_cost[c] / forecast_cost[0] * cost[0] / cost[c] - 1) < 0.05);
  }
}

TEST_CASE("A choice never leaves out light: a caustic of a point light", "[auto]") {
  // Cheap and without noise is path tracing here, but the caustic is out of its reach.
  const auto scene = scene_of(point_light + glass_ball);
  ThreadedExecutor executor(1);
  const RenderRequest request = request_for(*scene);
  REQUIRE(request.candidates.size() > 1);
  for (const SampleCounts& candidate : request.candidates) {
    INFO(candidate.light_paths << " " << candidate.connections << " " << candidate.merges);
    CHECK(candidate.traces_light());
    CHECK(candidate.merges);  // seen through the ball, the caustic is for merging alone
  }
  gmis::RenderSettings settings = request.settings;
  *settings.radius *= 20;  // more is merged, so that few iterations see it
  gmis::RenderPilot<BuiltScene::SceneType> pilot(scene->scene(), settings, gmis::all_candidates(settings.counts), 64);
  for (int i = 0; i < 16; ++i) pilot.iterate(executor);
  for (const Forecast& forecast : pilot.forecasts()) {
    if (forecast.counts.merges)
      CHECK(forecast.missing_share == 0.0);
    else
      CHECK(forecast.missing_share > gmis::negligible_share);
  }
}

TEST_CASE("Auto is right in the mean: against vcm, block by block", "[auto][long]") {
  // 9 blocks × 3 scenes; false alarms 1e-3.
  for (const std::string& world : {lamp + diffuse_ball, lamp + glass_ball, point_light + glass_ball}) {
    const auto scene = scene_of(world);
    ThreadedExecutor executor(1);
    const auto vcm = start(*scene, request_for(*scene, IntegratorChoice::vcm));
    RenderRequest request = request_for(*scene);
    request.settings.seed = gmis_test::seed(6);
    const auto chosen = start(*scene, request);
    constexpr int iterations = 200, blocks = 9;
    std::vector<gmis_test::Series> a(blocks), b(blocks);
    const auto add = [&](SceneEngine& source, std::vector<gmis_test::Series>& sums) {
      source.iterate(executor);
      std::vector<double> block(blocks, 0.0);
      for (std::size_t p = 0; p < source.engine().frame().size(); ++p)
        block[(p / 24 / 8) * 3 + p % 24 / 8] +=
            static_cast<double>(gmis::mean_channel(source.engine().frame()[p])) / 64;
      for (std::size_t k = 0; k < blocks; ++k) sums[k].add(block[k]);
    };
    for (int i = 0; i < iterations; ++i) {
      add(*vcm, a);
      add(*chosen, b);
    }
    REQUIRE(chosen->choice() != nullptr);
    for (std::size_t k = 0; k < blocks; ++k) {
      const double difference = a[k].mean() - b[k].mean();
      INFO("block " << k << ": " << a[k].mean() << " and " << b[k].mean());
      // 27 comparisons at 1e-3 in all are 4.1 standard errors each. Merging has a bias, of another
      // radius in each of the two: 1 % of a block is let pass.
      CHECK(std::abs(difference) <=
            4.1 * std::hypot(a[k].standard_error(), b[k].standard_error()) + 0.01 * a[k].mean());
    }
  }
}

TEST_CASE("The choice is the same for any number of threads, and so are the bits", "[auto]") {
  const auto scene = scene_of(lamp + glass_ball);
  std::vector<Spectrum> first;
  std::size_t chosen = 0;
  for (const int threads : {1, 2, 5}) {
    ThreadedExecutor executor(threads);
    const auto source = start(*scene, request_for(*scene));
    for (int i = 0; i < 4; ++i) source->iterate(executor);
    REQUIRE(source->choice() != nullptr);
    if (threads == 1) {
      first.assign(source->engine().frame().begin(), source->engine().frame().end());
      chosen = source->choice()->chosen.value();
    }
    CHECK(source->choice()->chosen == chosen);
    CHECK(std::memcmp(first.data(), source->engine().frame().data(), first.size() * sizeof(Spectrum)) == 0);
  }
}

TEST_CASE("Counts that are asked for are not chosen", "[auto]") {
  const auto scene = scene_of(lamp + glass_ball);
  Options options;
  options.connections = 4;
  for (const SampleCounts& candidate : request_for(*scene, IntegratorChoice::automatic, options).candidates)
    CHECK((candidate.connections == 4 || !candidate.traces_light()));
  for (const double light_paths : {0.3, 1.0}) {
    options.light_paths = light_paths;
    const RenderRequest request = request_for(*scene, IntegratorChoice::automatic, options);
    REQUIRE_FALSE(request.candidates.empty());
    for (const SampleCounts& candidate : request.candidates) {
      CHECK(candidate.connections == 4);
      CHECK(candidate.light_paths == light_paths);
    }
  }
  // With an integrator that is named, the number of connections is open, with local counts the
  // light trees and the radius, too.
  options = {};
  const auto all_of = [&](IntegratorChoice integrator) { return request_for(*scene, integrator, options).candidates; };
  for (const SampleCounts& candidate : all_of(IntegratorChoice::bpt)) {
    CHECK_FALSE(candidate.merges);
    CHECK(candidate.light_paths == 1.0);
  }
  CHECK(all_of(IntegratorChoice::vcm).size() == 2);
  CHECK(all_of(IntegratorChoice::ppm).empty());
  const auto all_of_split = [&](SplitChoice split) {
    RenderRequest request;
    request.integrator = options.integrator = IntegratorChoice::gmis;
    request.split = options.split = split;
    set_counts(request, options, *scene);
    return request.candidates;
  };
  CHECK(all_of_split(SplitChoice::local).size() == 2 * 3 * 4);
  for (const SampleCounts& candidate : all_of_split(SplitChoice::local)) {
    CHECK((candidate.light_paths > 0 && candidate.connections > 0 && candidate.splats && candidate.merges));
  }
  CHECK(all_of_split(SplitChoice::budgeted).size() == 2);
  options.light_paths = 1.0;
  CHECK(all_of_split(SplitChoice::local).size() == 2 * 3);
  options.light_paths.reset();
  options.connects_paired_tree = true;
  CHECK(all_of(IntegratorChoice::vcm).empty());
}

TEST_CASE("A crop is chosen for by its own pixels, wherever it lies", "[auto]") {
  const auto scene = scene_of(lamp + glass_ball);
  ThreadedExecutor executor(1);
  for (const gmis::PixelBounds& crop : {gmis::PixelBounds{{0, 5}, {24, 6}}, gmis::PixelBounds{{3, 11}, {9, 23}}}) {
    RenderRequest request = request_for(*scene);
    request.crop = crop;
    request.expected_iterations = 800;  // so few pixels need the longest pilot for a forecast that is not all noise
    const auto engine = start(*scene, request);
    engine->iterate(executor);
    REQUIRE(engine->choice() != nullptr);
    REQUIRE(engine->choice()->chosen.has_value());
    const Forecast& chosen = engine->choice()->forecasts[*engine->choice()->chosen];
    CHECK(chosen.variance > 0.0);
    CHECK(std::isfinite(chosen.variance));
    CHECK(chosen.cost > 0.0);
  }
}

TEST_CASE("Expected iterations follow the crop and the threads", "[auto]") {
  gmis::Budget budget;
  budget.seconds = 4.0;
  CHECK(expected_iterations(budget, 1000, 2) == 2 * expected_iterations(budget, 1000, 1));
  CHECK(expected_iterations(budget, 500, 1) == 2 * expected_iterations(budget, 1000, 1));
  budget.iterations = 7;
  CHECK(expected_iterations(budget, 1000, 4) == 7);
}
