#include "gmis/transport/pilot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/furnace_scene.hpp"

// What a pilot forecasts, against the variance that renderings with each candidate then have, pixel by pixel, in a furnace
// whose radiance is known. One radius for all iterations, since that of the pilot is fixed.

namespace {

using Scene = gmis_test::FurnaceScene<float>;
constexpr float albedo = 0.7F;
constexpr int size = 12, depth = 4, pixels = size * size;

gmis::RenderSettings settings() {
  gmis::RenderSettings result;
  result.max_depth = depth;
  result.radius = 0.05;
  result.alpha = 1.0;
  result.seed = gmis_test::seed(31);
  return result;
}

double truth() {
  const double a = static_cast<double>(albedo);
  return (1 - std::pow(a, depth)) / (1 - a);
}

struct Measured {
  double variance = 0, relative_error = 0, cost = 0;
};

/// The variance of an iteration relative to the squared truth, in batches, so that its own error is known.
template <class I>
Measured measure(const Scene& scene, const gmis::Candidate& candidate) {
  constexpr int batches = 10, iterations = 100;
  gmis::RenderSettings chosen = settings();
  chosen.seed += 1;
  chosen.light_paths = candidate.light_paths;
  chosen.connections = std::max(1, candidate.connections);
  chosen.camera_children = candidate.camera_children;
  gmis::Engine<Scene, I> engine(scene, chosen);
  gmis::SerialExecutor executor;
  double sum = 0, squares = 0;
  for (int b = 0; b < batches; ++b) {
    std::vector<double> mean(pixels, 0.0), variance(pixels, 0.0);
    for (int i = 1; i <= iterations; ++i) {
      engine.iterate(executor);
      for (std::size_t p = 0; p < pixels; ++p) {
        const double value = static_cast<double>(engine.frame()[p]), before = value - mean[p];
        mean[p] += before / i;
        variance[p] += before * (value - mean[p]) / (iterations - 1);
      }
    }
    double relative = 0;
    for (const double v : variance) relative += v / (truth() * truth() + gmis::relative_error_floor) / pixels;
    sum += relative / batches;
    squares += relative * relative / batches;
  }
  return {sum, std::sqrt(std::max(0.0, squares - sum * sum) / (batches - 1)) / sum,
          gmis::cost_of(engine.counters()) / (batches * iterations)};
}

}  // namespace

TEST_CASE("Forecasts of a pilot are the variance and the cost that renderings have", "[pilot]") {
  using namespace gmis::integrators;
  const Scene scene(albedo, 1.0F, size, 2);
  const std::vector<gmis::Candidate> candidates{
      {1.0, 1, true, true},  {0.0, 0, false, false},    {0.0, 0, false, false, 4}, {0.5, 0, true, false},
      {1.0, 4, true, false}, {0.25, 1, true, false, 2}, {0.5, 0, true, true},      {2.0, 1, true, true, 4},
      {0.25, 2, true, true}, {2.0, 4, true, false, 4}};
  const std::vector<Measured> measured{measure<Vcm>(scene, candidates[0]),
                                       measure<Pt>(scene, candidates[1]),
                                       measure<SplitCamera<Pt>>(scene, candidates[2]),
                                       measure<PtLt>(scene, candidates[3]),
                                       measure<Bpt>(scene, candidates[4]),
                                       measure<SplitCamera<Bpt>>(scene, candidates[5]),
                                       measure<PtLtPm>(scene, candidates[6]),
                                       measure<SplitCamera<Vcm>>(scene, candidates[7]),
                                       measure<Vcm>(scene, candidates[8]),
                                       measure<SplitCamera<Bpt>>(scene, candidates[9])};
  gmis::RenderPilot<Scene> pilot(scene, settings(), candidates, 1);
  pilot.compare_with(std::vector<double>(pixels, truth()));
  gmis::SerialExecutor executor;
  for (int i = 0; i < 1200; ++i) pilot.iterate(executor);
  // Further children cost no more here: what is compared is what was counted.
  gmis::OperationCosts costs;
  costs.further_child = 1.0;
  const std::vector<gmis::Forecast> forecasts = pilot.forecasts(costs);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const gmis::Candidate& candidate = candidates[c];
    CAPTURE(candidate.light_paths, candidate.connections, candidate.merges, candidate.camera_children);
    CAPTURE(forecasts[c].variance / measured[c].variance, measured[c].relative_error, forecasts[c].cost,
            measured[c].cost);
    // Four standard errors of the measurement, and 3 % for the pilot's noise and for its one expected density of merging
    // and of the light vertices that are drawn from.
    CHECK(std::abs(forecasts[c].variance / measured[c].variance - 1) < 0.03 + 4 * measured[c].relative_error);
    CHECK(measured[c].relative_error < 0.015);
    CHECK(std::abs(forecasts[c].cost / measured[c].cost - 1) < 0.02);
    CHECK(forecasts[c].missing_share == 0.0);
  }
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
