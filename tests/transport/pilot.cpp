#include "gmis/transport/allocation/pilot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"
#include "support/measured_variance.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"
#include "transport/mean_of_iterations.hpp"
#include "transport/ways.hpp"

// What a pilot forecasts, against the variance that renderings with each candidate then have, pixel
// by pixel, in a furnace whose radiance is known. One radius for all iterations, since that of the
// pilot is fixed.

namespace {

using Scene = gmis_test::FurnaceScene<float>;
using gmis_test::Series;
constexpr float albedo = 0.7F;
constexpr int size = 12, pixels = size * size;
/// From here all pixels are alike.
constexpr gmis::Vec3<float> centre{0, 0, 0};

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

/// Each forecast is compared with a measurement, all in one family: a false alarm in a thousandth
/// of the seeds.
constexpr std::size_t comparisons = 18;
const double level = gmis::sidak_level(1e-3, comparisons);
/// Independent renderings, and independent pilots: how far they are apart says how well their mean
/// is known.
constexpr std::size_t batches = 25;

struct Measured {
  gmis_test::RelativeVariance variance;
  double cost;
  double vertex_variance;  ///< the relative variance of V, the light vertices that an iteration stores
};

/// The variance and the cost of an iteration with the candidate's counts.
template <class I>
Measured measure(const Scene& scene, gmis::RenderSettings settings, const gmis::SampleCounts& candidate) {
  constexpr int iterations = 40;
  settings.counts.light_paths = candidate.light_paths;
  settings.counts.connections = std::max(1, candidate.connections);
  settings.counts.local_merges = candidate.local_merges;
  settings.counts.radius_factor = candidate.radius_factor;
  gmis::SerialExecutor executor;
  std::optional<typename I::template Engine<Scene>> engine;
  double cost = 0, vertices = 0, squares = 0;
  std::uint64_t stored = 0;
  int frames = 0;
  const gmis_test::MeasuredVariance variance(batches, iterations, [&] {
    if (frames++ % iterations == 0) {
      ++settings.seed;
      engine.emplace(scene, I::settings(settings));
      stored = 0;
    }
    const double cost_before = gmis::cost_of(engine->counters());
    engine->iterate(executor);
    cost += gmis::cost_of(engine->counters()) - cost_before;
    const auto new_vertices = static_cast<double>(engine->counters().photons_stored - stored);
    stored = engine->counters().photons_stored;
    vertices += new_vertices;
    squares += new_vertices * new_vertices;
    return engine->frame();
  });
  const double mean = vertices / frames;
  return {variance.relative_to(truth(settings.max_depth)), cost / frames,
          mean > 0 ? squares / frames / (mean * mean) - 1 : 0.0};
}

/// The mean of independent pilots' forecasts, of one candidate.
struct Forecasts {
  Series variance, cost;
};

void check_forecasts(const Scene& scene, gmis::RenderSettings settings,
                     const std::vector<gmis::SampleCounts>& candidates, const std::vector<Measured>& measured,
                     int pilot_iterations) {
  const gmis::OperationCosts costs;
  std::vector<Forecasts> forecasts(candidates.size());
  settings.seed += 1000;
  for (std::size_t batch = 0; batch < batches; ++batch) {
    ++settings.seed;
    gmis::RenderPilot<Scene> pilot(scene, settings, candidates, 1);
    pilot.compare_with(truth(settings.max_depth));
    gmis::SerialExecutor executor;
    for (int i = 0; i < pilot_iterations; ++i) pilot.iterate(executor);
    const std::vector<gmis::Forecast> all = pilot.forecasts(costs);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      forecasts[c].variance.add(all[c].variance);
      forecasts[c].cost.add(all[c].cost);
      CHECK(all[c].missing_share == 0.0);
    }
  }
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const gmis::SampleCounts& candidate = candidates[c];
    const double value = measured[c].variance.value;
    const double variance = forecasts[c].variance.mean(), cost = forecasts[c].cost.mean();
    const double error =
        std::hypot(measured[c].variance.relative_error, forecasts[c].variance.standard_error() / variance);
    // A connection is worth V / (m n_L), V the vertices of that iteration; a forecast has the mean
    // of V in place of V, and so a second moment of connections that is too small by up to the
    // relative variance of V. Welch's t has at least `batches` − 1 degrees of freedom.
    const double model = candidate.connections > 0 ? measured[c].vertex_variance : 0.0;
    const double limit = gmis::student_t_quantile(1 - level / 2, batches - 1) * error + model;
    CAPTURE(candidate.light_paths, candidate.connections, candidate.merges, candidate.local_merges,
            candidate.radius_factor);
    CAPTURE(variance / value, error, model, cost, measured[c].cost);
    CHECK(std::abs(variance / value - 1) < limit);
    CHECK(limit < 0.15);  // so that it says something
    CHECK(std::abs(cost / measured[c].cost - 1) < 0.02);
  }
}

}  // namespace

TEST_CASE("Forecasts of a pilot are the variance and the cost that renderings have", "[pilot][long]") {
  using namespace gmis_test::ways;
  const Scene scene(albedo, 1.0F, size, 2, centre);
  const std::vector<gmis::SampleCounts> candidates{
      {1.0, 1, true, true},  {0.0, 0, false, false}, {0.5, 0, true, false},
      {1.0, 4, true, false}, {0.25, 1, true, false}, {0.5, 0, true, true},
      {2.0, 1, true, true},  {0.25, 2, true, true},  {2.0, 16, true, false}};
  const auto all = settings();
  check_forecasts(scene, all, candidates,
                  {measure<Vcm>(scene, all, candidates[0]), measure<Pt>(scene, all, candidates[1]),
                   measure<PtLt>(scene, all, candidates[2]), measure<Bpt>(scene, all, candidates[3]),
                   measure<Bpt>(scene, all, candidates[4]), measure<PtLtPm>(scene, all, candidates[5]),
                   measure<Vcm>(scene, all, candidates[6]), measure<Vcm>(scene, all, candidates[7]),
                   measure<Bpt>(scene, all, candidates[8])},
                  50);
}

TEST_CASE("Forecasts with a local count of merging and other radii than the pilot's", "[pilot]") {
  using namespace gmis_test::ways;
  const Scene scene(albedo, 1.0F, size, 2, centre);
  auto all = settings();
  all.radius = 0.02;
  all.counts.local_merges = true;
  const auto merging = [](double light_paths, int connections, double factor) {
    return gmis::SampleCounts{light_paths, connections, true, true, true, true, true, true, factor};
  };
  const std::vector<gmis::SampleCounts> candidates{
      merging(1.0, 1, 1.0), merging(0.5, 0, 2.0), merging(0.25, 2, 4.0), merging(0.5, 1, 3.0), {0.5, 1, true, false}};
  check_forecasts(scene, all, candidates,
                  {measure<Vcm>(scene, all, candidates[0]), measure<PtLtPm>(scene, all, candidates[1]),
                   measure<Vcm>(scene, all, candidates[2]), measure<Vcm>(scene, all, candidates[3]),
                   measure<Bpt>(scene, all, candidates[4])},
                  50);
}

TEST_CASE("A pilot takes one pixel of each group of N, and not always the same one", "[pilot]") {
  struct Case {
    glm::ivec2 lower, upper;
    std::uint32_t iterations, step;
  };
  for (const Case& one : {Case{{0, 0}, {45, 45}, 64, 1},
                          {{0, 0}, {64, 64}, 64, 2},
                          {{3, 100}, {67, 501}, 1, 25},    // at least about 1024 pixels
                          {{0, 0}, {512, 512}, 64, 21},    // 3 · 512 · 8 = 12288 pixels
                          {{0, 0}, {512, 512}, 1000, 17},  // 3 · 512 · √96 = 15050
                          {{5, 7}, {9000, 8}, 64, 3},      // groups at the end of one pixel or two
                          {{5, 7}, {8992, 8}, 64, 3},
                          {{5, 7}, {8991, 8}, 64, 3},
                          {{5, 7}, {8989, 8}, 64, 3}}) {
    const gmis::PilotGrid grid({9000, 600}, {one.lower, one.upper}, one.iterations);
    CHECK(grid.step() == one.step);
    std::vector<std::uint32_t> of_place(one.step, 0);
    std::vector<int> of_tile(grid.tile_count(), 0);
    std::uint32_t number = 0, taken = 0, taken_in_group = 0;
    for (int y = one.lower.y; y < one.upper.y; ++y)
      for (int x = one.lower.x; x < one.upper.x; ++x, ++number) {
        if (number % one.step == 0 && number > 0) {
          CHECK(taken_in_group == 1);
          taken_in_group = 0;
        }
        const auto pixel = static_cast<std::uint32_t>(y * 9000 + x);
        if (!grid.takes(pixel)) continue;
        CHECK(grid.index(pixel) == taken);
        CHECK(grid.taken()[taken] == pixel);
        ++taken_in_group, ++taken, ++of_place[number % one.step], ++of_tile[grid.tile(pixel)];
      }
    CHECK(taken == (number + one.step - 1) / one.step);
    CHECK(grid.taken().size() == taken);
    for (const int row : {0, one.upper.y - one.lower.y - 1}) {
      const int first = (one.upper.x - one.lower.x) / 3, last = one.upper.x - one.lower.x - 1;
      std::vector<std::uint32_t> visited, expected;
      grid.for_each_in_row(row, first, last, [&](std::size_t i) { visited.push_back(grid.taken()[i]); });
      for (int x = first; x <= last; ++x) {
        const auto pixel = static_cast<std::uint32_t>((one.lower.y + row) * 9000 + one.lower.x + x);
        if (grid.takes(pixel)) expected.push_back(pixel);
      }
      CHECK(visited == expected);
    }
    // A hash, which needs no seed: no place has less than half or more than twice its share.
    for (const std::uint32_t count : of_place) {
      CHECK(2 * count * one.step >= taken);
      CHECK(count * one.step <= 2 * taken);
    }
    CHECK(*std::max_element(of_tile.begin(), of_tile.end()) <= 128);
    const int width = 2 * grid.reach() + 1;
    CHECK(width * width >= 16 * static_cast<int>(one.step));
    CHECK(width * width <= 36 * static_cast<int>(one.step));
    CHECK_FALSE(grid.takes(static_cast<std::uint32_t>(one.upper.y * 9000)));  // below the crop
  }
}

TEST_CASE("A pilot that takes every second pixel forecasts what one that takes all of them does", "[pilot][long]") {
  // From the centre all pixels are alike. In the larger picture half are taken; the cost is that of
  // all. Nothing is merged: pixels that share photons are not independent, and more trees would be
  // merged within one radius.
  const Scene all(albedo, 1.0F, 45, 2, centre), larger(albedo, 1.0F, 64, 2, centre);
  const std::vector<gmis::SampleCounts> candidates{
      {0.0, 0, false, false}, {1.0, 1, true, false}, {0.5, 0, true, false}, {0.5, 2, true, false}};
  // The value that errors are relative to: the truth, or that of the pictures themselves.
  std::array<std::vector<Series>, 4> variances, costs;
  for (auto* each : {&variances, &costs}) each->fill(std::vector<Series>(candidates.size()));
  auto own = settings();
  own.counts.merges = false;
  for (std::size_t batch = 0; batch < batches; ++batch)
    for (std::size_t kind = 0; kind < 4; ++kind) {
      ++own.seed;
      const bool is_large = kind % 2 == 1, knows_truth = kind < 2;
      const int side = is_large ? 64 : 45;
      gmis::RenderPilot<Scene> pilot(is_large ? larger : all, own, candidates, 64);
      if (knows_truth)
        pilot.compare_with(std::vector<double>(static_cast<std::size_t>(side * side), truth(own.max_depth).front()));
      gmis::SerialExecutor executor;
      for (int i = 0; i < 4; ++i) pilot.iterate(executor);
      const auto paths = static_cast<std::uint64_t>(is_large ? side * side / 2 : side * side);
      CHECK(pilot.engine().counters().camera_paths == 4 * paths);
      const auto forecasts = pilot.forecasts();
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        variances[kind][c].add(forecasts[c].variance);
        costs[kind][c].add(forecasts[c].cost / (side * side));
      }
    }
  const double t = gmis::student_t_quantile(1 - gmis::sidak_level(1e-3, 7 * candidates.size()) / 2, batches - 1);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    CAPTURE(c);
    const auto check_equal = [&](const Series& a, const Series& b, double most) {
      const double limit = t * std::hypot(a.standard_error(), b.standard_error()) / b.mean();
      CAPTURE(a.mean() / b.mean(), limit);
      CHECK(std::abs(a.mean() / b.mean() - 1) < limit);
      CHECK(limit < most);  // so that it says something
    };
    check_equal(variances[1][c], variances[0][c], 0.2);
    check_equal(variances[3][c], variances[2][c], 0.2);
    for (std::size_t kind = 0; kind < 2; ++kind) {
      // The mean of 1 / value² is larger than with the true value [Jensen], by a few per cent here:
      // noise that pixels share.
      const Series &own_picture = variances[2 + kind][c], &with_truth = variances[kind][c];
      const double limit = t * std::hypot(own_picture.standard_error(), with_truth.standard_error());
      CHECK(own_picture.mean() > with_truth.mean() - limit);
      CHECK(own_picture.mean() < 1.15 * with_truth.mean() + limit);
    }
    check_equal(costs[1][c], costs[0][c], 0.05);
    check_equal(costs[3][c], costs[2][c], 0.05);
    check_equal(costs[2][c], costs[0][c], 0.05);
  }
}

TEST_CASE("What merging changes in the pilot's picture is what it says of the candidate with its own counts",
          "[pilot]") {
  const Scene scene(albedo, 1.0F, size, 2, centre);
  gmis::RenderSettings own = settings();
  own.radius = 0.3;
  own.counts = {0.5, 2, true, true};
  using PilotEngine = gmis::RenderPilot<Scene>::EngineType;
  PilotEngine engine(scene, own);
  gmis::PilotCandidates candidates;
  candidates.grid = gmis::PilotGrid({size, size}, engine.crop(), 1);
  candidates.made = own.counts;
  candidates.add(own.counts);
  engine.for_each_output([&](auto& output) { output.analyse(&candidates); });
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  float greatest = 0.0F;
  std::size_t i = 0;
  engine.for_each_output([&](auto& output) {
    for (const float change : output.kernel_changes) {
      CHECK(engine.merging_change()[candidates.grid.taken()[i++]] == Approx(change).epsilon(1e-3).margin(1e-4));
      greatest = std::max(greatest, std::abs(change));
    }
  });
  CHECK(i == candidates.grid.taken().size());
  CHECK(greatest > 0.01F);
}

namespace {

/// Merging within a wide disk and within half of it, with two light trees a pixel, of which a pilot
/// has an eighth.
std::array<gmis::SampleCounts, 2> wide_and_half() {
  const gmis::SampleCounts merges{2.0, 0, false, true, 1, true, true, false, 4.0};
  gmis::SampleCounts half = merges;
  half.radius_factor = 2.0;
  return {merges, half};
}

/// The mean of a rendering by these counts, with one light tree a pixel: trees have no part in the
/// bias.
double mean_with(const Scene& scene, auto rendered, const gmis::SampleCounts& counts, int iterations) {
  rendered.counts = counts;
  rendered.counts.light_paths = 1.0;
  gmis::Engine<Scene> engine(scene, rendered);
  return gmis_test::means_of_iterations(engine, iterations).mean();
}

}  // namespace

TEST_CASE("A pilot sees the bias of merging", "[pilot][slow]") {
  // On the curved wall a photon whose light comes from below the camera vertex's horizon is lost:
  // r²/8 of the light that is merged (furnace_techniques.cpp); a wide disk loses more, the photons
  // whose normals are too far apart (`Merge::least_normal_cosine`). What runs lose is measured with
  // both disks; what the pilot says is 4/3 of the difference, for a loss in proportion to r².
  using namespace gmis_test::ways;
  const Scene scene(albedo, 1.0F, size, 2, centre);
  auto wide = settings();
  wide.radius = 0.2;
  const auto [merges, half] = wide_and_half();
  auto rendered = wide;
  gmis::SerialExecutor executor;
  constexpr std::size_t count = 90;  // enough that limits hardly vary
  constexpr int iterations = 125;
  const auto loss_with = [&](const gmis::SampleCounts& counts) {
    ++rendered.seed;
    return 1 - mean_with(scene, rendered, counts, iterations) / truth(wide.max_depth).front();
  };
  Series losses, of_merges, of_half;
  for (std::size_t batch = 0; batch < count; ++batch) {
    losses.add(4.0 / 3 * (loss_with(merges) - loss_with(half)));
    ++wide.seed;
    gmis::RenderPilot<Scene> pilot(scene, wide, {merges, half}, 1);
    pilot.compare_with(truth(wide.max_depth));
    for (int i = 0; i < iterations; ++i) pilot.iterate(executor);
    const auto forecasts = pilot.forecasts();
    of_merges.add(forecasts[0].squared_bias);
    of_half.add(forecasts[1].squared_bias);
  }
  // The pilot's bias is relative to the light that merging leaves, which makes it 8 % larger. The
  // forecast is a lower bound, but noise takes less than 0.3 of the loss away.
  const double loss = losses.mean(), forecast = of_merges.mean();
  const double limit = gmis::student_t_quantile(1 - level / 2, count - 1) *
                       std::hypot(2 * loss * losses.standard_error(), of_merges.standard_error());
  CAPTURE(loss, std::sqrt(forecast), limit);
  CHECK(forecast < gmis::square(1.08 * loss) + limit);
  CHECK(forecast > gmis::square(0.7 * loss) - limit);
  CHECK(of_half.mean() < forecast / 4);     // a sixteenth, and noise
  CHECK(limit < gmis::square(0.5 * loss));  // so that it says something: it is 0.17 ± 0.02 of the squared loss
}

TEST_CASE("In two iterations no tile shows the bias of merging, but the whole of a picture does", "[pilot]") {
  using namespace gmis_test::ways;
  constexpr int side = 32;
  constexpr std::size_t count = 24;
  const Scene scene(albedo, 1.0F, side, 2, centre);
  auto wide = settings();
  wide.radius = 0.16;
  const auto candidates = wide_and_half();
  gmis::SerialExecutor executor;
  std::vector<double> biases;
  Series losses;
  for (std::size_t i = 0; i < count; ++i) {
    ++wide.seed;
    gmis::RenderPilot<Scene> pilot(scene, wide, {candidates[0], candidates[1]}, 1);
    pilot.compare_with(std::vector<double>(side * side, truth(wide.max_depth).front()));
    for (int k = 0; k < 2; ++k) pilot.iterate(executor);
    biases.push_back(pilot.forecasts()[0].squared_bias);
    const double narrower = mean_with(scene, wide, candidates[1], 1), wider = mean_with(scene, wide, candidates[0], 1);
    losses.add(4.0 / 3 * (narrower - wider) / truth(wide.max_depth).front());
  }
  // The bound is one standard error below a noisy estimate. 73 of 100 pilots see more than half of
  // the loss, and none of 100 by tiles alone; fewer than 5 of 24 would be a false alarm in 1e-8 of
  // the seeds.
  const auto seen = std::count_if(biases.begin(), biases.end(),
                                  [&](double bias) { return bias > gmis::square(0.5 * losses.mean()); });
  CAPTURE(losses.mean(), losses.standard_error());
  CHECK(seen >= 5);
}

namespace {

using Colour = gmis::Vec3<float>;

/// An engine without a scene: the test fills its frame.
struct FilledEngine final : gmis::AnyEngine<Colour> {
  FilledEngine(const gmis::RenderSettings& settings, int side)
      : gmis::AnyEngine<Colour>(settings, {side, side}, std::nullopt) {}
  void fill(const std::vector<Colour>& picture) {
    frame_ = picture;
    counters_.camera_paths += picture.size();
    ++iteration_;
  }
  void iterate(gmis::ExecutorRef) override {}
  void learn_lights(std::uint64_t, gmis::ExecutorRef) override {}
  std::shared_ptr<const gmis::AnyLearnedLights> learned_lights() const noexcept override { return nullptr; }
  gmis::LightUse light_use() const noexcept override { return {}; }
  void use_lights(std::shared_ptr<const gmis::AnyLearnedLights>) override {}
  void keep_contributions(bool) override {}
  void for_each_contribution(const std::function<void(const gmis::Contribution<Colour>&)>&) const override {}
  std::size_t photon_bytes() const noexcept override { return 0; }
};

/// A pilot whose contributions the test makes.
class FedPilot final : public gmis::AnyPilot<Colour> {
 public:
  FedPilot(const std::vector<gmis::SampleCounts>& candidates, const gmis::RenderSettings& settings, int side)
      : gmis::AnyPilot<Colour>(candidates, settings.counts), engine_(settings, side) {
    observe({&output_}, {side, side}, 64);
  }
  /// An iteration in which every pixel has one contribution, `make(pixel)`: its value and the
  /// densities of its path.
  template <class Make>
  void iterate_with(Make&& make) {
    output_.clear();
    std::vector<Colour> picture;
    for (std::uint32_t pixel = 0; pixel < engine_.frame().size(); ++pixel) {
      const auto [value, densities] = make(pixel);
      output_.begin_pixel(pixel);
      output_.add({densities.own, 1, 2}, Colour(value), densities);
      output_.end_vertex();
      picture.push_back(output_.take_pixel());
    }
    engine_.fill(picture);
    end_iteration(0);
  }
  void iterate(gmis::ExecutorRef) override {}
  void learn_lights(std::uint64_t, gmis::ExecutorRef) override {}
  const gmis::AnyEngine<Colour>& engine() const noexcept override { return engine_; }

 private:
  FilledEngine engine_;
  gmis::PilotOutput<Colour> output_;
};

}  // namespace

TEST_CASE("A pilot leaves out the brightest thousandth of its pixels: two of a thousand, none of fewer", "[pilot]") {
  const auto left_out = [](std::size_t count) {
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>((7 * i) % count));  // a shuffle
    const double threshold = gmis::detail::firefly_threshold(values);
    return std::count_if(values.begin(), values.end(), [&](double value) { return value > threshold; });
  };
  CHECK(left_out(1) == 0);
  CHECK(left_out(999) == 0);
  CHECK(left_out(1000) == 2);
  CHECK(left_out(1844) == 2);
  CHECK(left_out(3000) == 3);
  CHECK(left_out(9217) == 9);
  CHECK(gmis::detail::firefly_threshold({}) == 0.0);
}

TEST_CASE("Fireflies in one pixel of both iterations do not make path tracing look free of noise", "[pilot]") {
  // Connections make each path with 99 times the density of emitter hits, and the light of a pixel
  // is 1: its second moment is 1 with connections, 100 with path tracing. A connection, weighted
  // by the balance heuristic, contributes 1. With fireflies, one pixel has an emitter hit in both
  // iterations instead: its value is 100, its weight 1/100.
  constexpr int side = 8;
  gmis::RenderSettings own;
  own.counts = {1.0, 2, false, false};
  const gmis::SampleCounts path_tracing{0.0, 0, false, false}, connecting{1.0, 2, false, false};
  const auto forecast = [&](bool has_fireflies) {
    FedPilot pilot({path_tracing, connecting}, own, side);
    pilot.compare_with(std::vector<double>(side * side, 1.0));
    for (int i = 0; i < 2; ++i)
      pilot.iterate_with([&](std::uint32_t pixel) {
        gmis::TechniqueDensities<float> densities{gmis::Technique::connect, {}};
        densities.relative[static_cast<std::size_t>(gmis::Technique::emitter_hit)] = 1.0F / 99;
        densities.relative[static_cast<std::size_t>(gmis::Technique::connect)] = 1.0F;
        if (!has_fireflies || pixel != 20) return std::pair(100.0F / 99, densities);
        densities.own = gmis::Technique::emitter_hit;
        for (float& density : densities.relative) density *= 99;
        return std::pair(100.0F, densities);
      });
    return pilot.forecasts();
  };
  const auto calm = forecast(false), wild = forecast(true);
  CHECK(calm[0].variance == Approx(100 / (1 + gmis::relative_error_floor)));
  CHECK(calm[1].variance == Approx(0).margin(1e-4));
  // The product of the fireflies is 100², which alone would take 156 from the mean of 64 pixels.
  CHECK(wild[0].variance > 0.9 * calm[0].variance);
  CHECK(wild[0].variance <= calm[0].variance);
  CHECK(wild[1].variance == Approx(0).margin(1e-4));
}

TEST_CASE("What pays in a scene, as data", "[pilot]") {
  const Scene scene(albedo, 1.0F, size, 2);
  gmis::SerialExecutor executor;
  gmis::RenderPilot<Scene> pilot(scene, settings(), gmis::all_candidates(), 64);
  for (int i = 0; i < 2; ++i) pilot.iterate(executor);
  const std::vector<gmis::Forecast> forecasts = pilot.forecasts();
  const gmis::SampleCounts& best = forecasts[gmis::best_of(forecasts, 64)].counts;
  std::printf("%g light trees a pixel, %d connections a vertex, merging %s\n", best.light_paths, best.connections,
              best.merges ? "on" : "off");
  // Every candidate has emitter hits, which can make all light here.
  CHECK(forecasts.size() == gmis::all_candidates().size());
  for (const gmis::Forecast& forecast : forecasts) CHECK(forecast.missing_share == 0.0);
}
