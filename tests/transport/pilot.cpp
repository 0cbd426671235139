#include "gmis/transport/choose/pilot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "support/catch.hpp"
#include "support/measured_variance.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

// What a pilot forecasts, against the variance that renderings with each candidate then have, pixel by pixel, in a furnace
// whose radiance is known. One radius for all iterations, since that of the pilot is fixed.

namespace {

using Scene = gmis_test::FurnaceScene<float>;
constexpr float albedo = 0.7F;
constexpr int size = 12, pixels = size * size;

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = 4;
  result.radius = 0.05;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(31);
  return result;
}

std::vector<double> truth(int max_depth) {
  const double a = static_cast<double>(albedo);
  return std::vector<double>(pixels, (1 - std::pow(a, max_depth)) / (1 - a));
}

struct Measured {
  gmis_test::RelativeVariance variance;
  double cost;
};

/// What an iteration with the candidate's counts then has.
template <class I>
Measured measure(const Scene& scene, gmis::RenderSettings settings, const gmis::Candidate& candidate) {
  constexpr int batches = 10, iterations = 100;
  settings.seed += 1;
  settings.counts.light_paths = candidate.light_paths;
  settings.counts.connections = std::max(1, candidate.connections);
  settings.counts.camera_children = candidate.camera_children;
  typename I::template Engine<Scene> engine(scene, I::settings(settings));
  gmis::SerialExecutor executor;
  const gmis_test::MeasuredVariance variance(batches, iterations, [&] {
    engine.iterate(executor);
    return engine.frame();
  });
  return {variance.relative_to(truth(settings.max_depth)), gmis::cost_of(engine.counters()) / (batches * iterations)};
}

void check_forecasts(const Scene& scene, const gmis::RenderSettings& settings,
                     const std::vector<gmis::Candidate>& candidates, const std::vector<Measured>& measured) {
  gmis::RenderPilot<Scene> pilot(scene, settings, candidates, 1);
  pilot.compare_with(truth(settings.max_depth));
  gmis::SerialExecutor executor;
  for (int i = 0; i < 1200; ++i) pilot.iterate(executor);
  gmis::OperationCosts costs;
  costs.further_child = 1.0;  // the operations are what is compared
  const std::vector<gmis::Forecast> forecasts = pilot.forecasts(costs);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const gmis::Candidate& candidate = candidates[c];
    const auto& [value, relative_error] = measured[c].variance;
    CAPTURE(candidate.light_paths, candidate.connections, candidate.merges, candidate.camera_children);
    CAPTURE(forecasts[c].variance / value, relative_error, forecasts[c].cost, measured[c].cost);
    // Four standard errors of the measurement, and 3 % for the pilot's noise and for its one expected density of merging
    // and of the light vertices that are drawn from.
    CHECK(std::abs(forecasts[c].variance / value - 1) < 0.03 + 4 * relative_error);
    CHECK(relative_error < 0.015);
    CHECK(std::abs(forecasts[c].cost / measured[c].cost - 1) < 0.02);
    CHECK(forecasts[c].missing_share == 0.0);
  }
}

}  // namespace

TEST_CASE("Forecasts of a pilot are the variance and the cost that renderings have", "[pilot]") {
  using namespace gmis_test::ways;
  const Scene scene(albedo, 1.0F, size, 2);
  const std::vector<gmis::Candidate> candidates{
      {1.0, 1, true, true},  {0.0, 0, false, false},    {0.0, 0, false, false, 4}, {0.5, 0, true, false},
      {1.0, 4, true, false}, {0.25, 1, true, false, 2}, {0.5, 0, true, true},      {2.0, 1, true, true, 4},
      {0.25, 2, true, true}, {2.0, 4, true, false, 4}};
  const auto all = settings();
  check_forecasts(scene, all, candidates,
                  {measure<Vcm>(scene, all, candidates[0]), measure<Pt>(scene, all, candidates[1]),
                   measure<Pt>(scene, all, candidates[2]), measure<PtLt>(scene, all, candidates[3]),
                   measure<Bpt>(scene, all, candidates[4]), measure<Bpt>(scene, all, candidates[5]),
                   measure<PtLtPm>(scene, all, candidates[6]), measure<Vcm>(scene, all, candidates[7]),
                   measure<Vcm>(scene, all, candidates[8]), measure<Bpt>(scene, all, candidates[9])});
}

TEST_CASE("Of direct light a split saves what its children make by hitting the light", "[pilot]") {
  using namespace gmis_test::ways;
  const Scene scene(albedo, 1.0F, size, 2);
  const std::vector<gmis::Candidate> candidates{
      {0.0, 0, false, false}, {0.0, 0, false, false, 4}, {1.0, 0, true, true, 4}};
  auto direct = settings();
  direct.max_depth = 2;
  check_forecasts(scene, direct, candidates,
                  {measure<Pt>(scene, direct, candidates[0]), measure<Pt>(scene, direct, candidates[1]),
                   measure<PtLtPm>(scene, direct, candidates[2])});
}

TEST_CASE("A pilot's forecasts by region add up", "[pilot]") {
  const Scene scene(albedo, 1.0F, size, 2);
  const std::vector<gmis::Candidate> candidates = gmis::all_candidates({});
  gmis::RenderPilot<Scene> pilot(scene, settings(), candidates, 1);
  gmis::SerialExecutor executor;
  for (int i = 0; i < 2; ++i) pilot.iterate(executor);
  const std::vector<gmis::Forecast> all = pilot.forecasts();
  std::vector<double> variance(candidates.size(), 0.0), cost(candidates.size(), 0.0);
  for (std::size_t r = 0; r < gmis::PilotGrid::region_count(); ++r) {
    const std::vector<gmis::Forecast> own = pilot.forecasts_of_region(r);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      variance[c] += own[c].variance;
      cost[c] += own[c].cost;
    }
  }
  double least = std::numeric_limits<double>::max();
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (candidates[c].camera_children == 1) CHECK(all[c].variance == Approx(variance[c]));  // else bounds come in
    CHECK(all[c].cost == Approx(cost[c] + pilot.light_cost(candidates[c])));
    least = std::min(least, all[c].variance * all[c].cost);
  }
  // All regions alike is one of the choices; but light trees are counted there for all that any of them may use.
  CHECK(pilot.least_work_by_region() < 1.2 * least);
}

TEST_CASE("What pays in a scene, as data", "[pilot]") {
  const Scene scene(albedo, 1.0F, size, 2);
  gmis::SerialExecutor executor;
  gmis::RenderPilot<Scene> pilot(scene, settings(), gmis::all_candidates({}), 64);
  for (int i = 0; i < 2; ++i) pilot.iterate(executor);
  const std::vector<gmis::Forecast> forecasts = pilot.forecasts();
  const gmis::Candidate& best = forecasts[gmis::best_of(forecasts, 64)].candidate;
  std::printf("%g light trees a pixel, %d connections a vertex, merging %s, %d children\n", best.light_paths,
              best.connections, best.merges ? "on" : "off", best.camera_children);
  CHECK(pilot.engine().frame().size() == pixels);  // a picture like any other
}
