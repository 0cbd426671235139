#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/render/thread_executor.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/continued_run.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

// Pictures with counts from a table: the mean is that of the closed form for any table, technique by technique, and the weights
// keep their bits.

namespace {

using Scene = gmis_test::FurnaceScene<float>;
using Table = gmis::CountTable<float>;
using Cells = gmis::VertexCells<float>;
using Both = gmis::Engine<Scene>;
using OneSide = gmis::PathTracer<Scene>;

constexpr int size = 12;
constexpr float albedo = 0.6F;
constexpr int depth = 5;

gmis::RenderSettings settings_for(const gmis::SampleCounts& counts, std::uint64_t seed) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.seed = seed;
  settings.max_depth = depth;
  settings.radius = 0.3;
  settings.vertex_counts = gmis::VertexCounts::learned;
  return settings;
}

/// Boxes over the furnace: the unit ball.
Cells cells_of_ball() {
  std::vector<gmis::Vec3<float>> points;
  for (int i = 0; i < 4000; ++i) {
    const float t = static_cast<float>(i) / 2000 - 1;
    points.push_back({t, t, t});
  }
  return Cells(points);
}

/// A table with a random count for everything in every cell, in [0.05, 8] at the importance 1; W is random, too.
Table random_table(gmis::Philox& source) {
  std::vector<Table::Entry> entries(Cells::count);
  for (Table::Entry& entry : entries)
    for (std::size_t k = 0; k < 4; ++k) {
      const float n = 0.05F * std::pow(160.0F, gmis::uniform<float>(source));
      entry.split[k] = gmis::uniform<float>(source) < 0.5F ? n : 0.0F;
      entry.roulette[k] = gmis::uniform<float>(source) < 0.5F ? n : std::numeric_limits<float>::infinity();
    }
  std::vector<float> scales(size * size);
  for (float& scale : scales) scale = 0.3F + 2 * gmis::uniform<float>(source);
  return {cells_of_ball(), entries, scales, 0.05F};
}

/// One sample of everything.
Table table_of_ones() {
  Table::Entry entry;
  entry.roulette.fill(std::numeric_limits<float>::infinity());
  return {Cells(), std::vector<Table::Entry>(Cells::count, entry), std::vector<float>(size * size, 1.0F), 0.05F};
}

const std::array<std::pair<const char*, gmis::SampleCounts>, 4> ways{{{"pt", gmis::integrators::pt},
                                                                      {"bpt", gmis::integrators::bpt},
                                                                      {"vcm", gmis::integrators::vcm},
                                                                      {"bpm", gmis::integrators::bpm}}};

/// Sum over the pixels of the contributions of each technique, for each iteration.
template <class Engine>
std::vector<std::array<double, gmis::technique_count>> sums(Engine& engine, int iterations) {
  gmis::SerialExecutor executor;
  engine.keep_contributions(true);
  std::vector<std::array<double, gmis::technique_count>> all(static_cast<std::size_t>(iterations));
  for (auto& by_technique : all) {
    engine.iterate(executor);
    engine.for_each_contribution([&](const gmis::Contribution<float>& one) {
      by_technique[static_cast<std::size_t>(one.id.technique)] +=
          static_cast<double>(one.value) * static_cast<double>(one.weight);
    });
  }
  return all;
}

template <class Engine, class Executor = gmis::SerialExecutor>
std::vector<float> frames(const Scene& scene, const gmis::RenderSettings& settings, const Table* table, int iterations,
                          Executor executor = {}) {
  Engine engine(scene, settings);
  if (table != nullptr) engine.use_count_table(*table);
  std::vector<float> all;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    all.insert(all.end(), engine.frame().begin(), engine.frame().end());
  }
  return all;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

template <class Engine>
void check_energy(const char* name, const gmis::SampleCounts& counts, std::uint64_t seed) {
  CAPTURE(name);
  constexpr int iterations = 400, tables = 4;
  const Scene scene(albedo, 1.0F, size, 2);
  gmis::RenderSettings plain = settings_for(counts, gmis_test::seed(seed));
  plain.vertex_counts = gmis::VertexCounts::uniform;
  Engine without(scene, plain);
  const auto expected = sums(without, iterations);
  // Each technique with each table, in four ways.
  const double level = gmis::sidak_level(1e-3, gmis::technique_count * tables * ways.size());
  for (int t = 0; t < tables; ++t) {
    gmis::Philox source(gmis_test::seed(seed), 7, static_cast<std::uint32_t>(t));
    Engine with(scene, settings_for(counts, gmis_test::seed(seed + 100 + static_cast<std::uint64_t>(t))));
    with.use_count_table(random_table(source));
    const auto made = sums(with, iterations);
    for (std::size_t k = 0; k < gmis::technique_count; ++k) {
      double mean[2]{}, square[2]{};
      for (std::size_t i = 0; i < iterations; ++i) {
        mean[0] += expected[i][k] / iterations, mean[1] += made[i][k] / iterations;
      }
      for (std::size_t i = 0; i < iterations; ++i) {
        square[0] += std::pow(expected[i][k] - mean[0], 2), square[1] += std::pow(made[i][k] - mean[1], 2);
      }
      const double error = std::sqrt((square[0] + square[1]) / (iterations * (iterations - 1.0)));
      CAPTURE(t, k, mean[0], mean[1], error);
      if (!counts.has(static_cast<gmis::Technique>(k))) {
        CHECK(mean[1] == 0);
        continue;
      }
      REQUIRE(error > 0);
      CHECK(gmis::student_t_p_value((mean[1] - mean[0]) / error, iterations - 1.0) > level);
    }
  }
}

}  // namespace

TEST_CASE("Any table leaves the mean of every technique as it is") {
  check_energy<OneSide>(ways[0].first, ways[0].second, 11);
  for (std::size_t i = 1; i < ways.size(); ++i) check_energy<Both>(ways[i].first, ways[i].second, 20 + i);
}

TEST_CASE("Any table gives the furnace its closed form") {
  // L (1 − a^D)/(1 − a); merging is left out, because its density estimate is biased where the disk ends.
  const double expected = (1 - std::pow(static_cast<double>(albedo), depth)) / (1 - static_cast<double>(albedo));
  constexpr int iterations = 300;
  const Scene scene(albedo, 1.0F, size, 1);
  const double level = gmis::sidak_level(1e-3, 6);
  for (std::uint64_t t = 0; t < 6; ++t) {
    gmis::Philox source(gmis_test::seed(31), 7, static_cast<std::uint32_t>(t));
    const Table table = random_table(source);
    const auto settings =
        settings_for(t % 2 == 0 ? gmis::integrators::pt : gmis::integrators::bpt, gmis_test::seed(40 + t));
    const auto all = t % 2 == 0 ? frames<OneSide>(scene, settings, &table, iterations)
                                : frames<Both>(scene, settings, &table, iterations);
    double sum = 0, squares = 0;
    for (int i = 0; i < iterations; ++i) {
      double mean = 0;
      for (int p = 0; p < size * size; ++p)
        mean += static_cast<double>(all[static_cast<std::size_t>(i * size * size + p)]) / (size * size);
      sum += mean, squares += mean * mean;
    }
    const double mean = sum / iterations;
    const double error = std::sqrt((squares / iterations - mean * mean) / (iterations - 1.0));
    CAPTURE(t, mean, expected, error);
    CHECK(gmis::student_t_p_value((mean - expected) / error, iterations - 1.0) > level);
  }
}

TEST_CASE("A table with the count 1 everywhere changes no bit, and neither does learning") {
  const Scene scene(albedo, 1.0F, size, 2);
  const Table ones = table_of_ones();
  for (const auto& [name, counts] : ways) {
    CAPTURE(name);
    auto uniform = settings_for(counts, gmis_test::seed(51));
    uniform.vertex_counts = gmis::VertexCounts::uniform;
    const auto learned = settings_for(counts, gmis_test::seed(51));
    const bool is_two_sided = counts.traces_light();
    const auto render = [&](const gmis::RenderSettings& settings, const Table* table, int iterations) {
      return is_two_sided ? frames<Both>(scene, settings, table, iterations)
                          : frames<OneSide>(scene, settings, table, iterations);
    };
    CHECK(same_bits(render(uniform, nullptr, 3), render(learned, &ones, 3)));
    const int learning = gmis::CountLearner<float>::iterations;
    CHECK(same_bits(render(uniform, nullptr, learning), render(learned, nullptr, learning)));
  }
}

TEST_CASE("Weights keep their bits: samples are only added, each with a share") {
  const Scene scene(albedo, 1.0F, size, 2);
  for (const auto work : {gmis::VertexWork::next_event, gmis::VertexWork::connect}) {
    const auto shared = work == gmis::VertexWork::next_event ? gmis::Technique::next_event : gmis::Technique::connect;
    CAPTURE(static_cast<int>(work));
    gmis::SampleCounts counts = gmis::integrators::vcm;
    // Next events come first: more of them would give connections other numbers, where these draw any.
    if (work == gmis::VertexWork::next_event) counts.connections = gmis::paired_connections;
    auto plain = settings_for(counts, gmis_test::seed(61));
    plain.vertex_counts = gmis::VertexCounts::uniform;
    Both without(scene, plain), with(scene, settings_for(counts, gmis_test::seed(61)));
    Table::Entry entry;  // 8 samples at any importance
    entry.roulette.fill(std::numeric_limits<float>::infinity());
    entry.split[static_cast<std::size_t>(work)] = 1e30F;
    with.use_count_table(
        {Cells(), std::vector<Table::Entry>(Cells::count, entry), std::vector<float>(size * size, 1.0F), 0.05F});
    gmis::SerialExecutor executor;
    std::array<std::vector<gmis::Contribution<float>>, 2> made;
    for (const std::size_t i : {0U, 1U}) {
      Both& engine = i == 0 ? without : with;
      engine.keep_contributions(true);
      engine.iterate(executor);
      engine.for_each_contribution([&](const auto& one) { made[i].push_back(one); });
    }
    CHECK(made[1].size() > made[0].size() + 7 * size * size);
    std::size_t at = 0;
    std::array<int, gmis::technique_count> found{};
    for (const auto& one : made[0]) {
      const float value = one.id.technique == shared ? one.value / 8 : one.value;
      const auto is_same = [&](const auto& other) {
        return other.pixel == one.pixel && other.id.technique == one.id.technique && other.id.s == one.id.s &&
               other.id.t == one.id.t && std::memcmp(&other.weight, &one.weight, sizeof one.weight) == 0 &&
               other.value == value;
      };
      while (at < made[1].size() && !is_same(made[1][at])) ++at;
      REQUIRE(at < made[1].size());
      ++at;
      ++found[static_cast<std::size_t>(one.id.technique)];
    }
    for (const int count : found) CHECK(count > 0);
  }
}

TEST_CASE("The log of real subpaths adds up to their contributions, and its costs to their work") {
  const Scene scene(albedo, 1.0F, size, 2);
  auto settings = settings_for(gmis::integrators::vcm, gmis_test::seed(71));
  settings.vertex_counts = gmis::VertexCounts::uniform;
  Both engine(scene, settings);
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  const auto context = engine.context();
  gmis::FilmOutput<float> output;
  output.keep_contributions(true);
  gmis::VertexLog<float> log;
  gmis::CameraSubpath<Both::Context, gmis::FilmOutput<float>> subpath(context, output);
  subpath.log_to(&log);
  int vertices = 0;
  for (std::uint32_t pixel = 0; pixel < size * size; ++pixel) {
    output.clear();
    log.clear();
    output.begin_pixel(pixel);
    subpath.trace({static_cast<int>(pixel) % size, static_cast<int>(pixel) / size}, pixel,
                  Both::numbers_of(context, gmis::PathKind::camera, pixel));
    CHECK(output.take_pixel() <= engine.frame()[pixel]);  // which has the splats, too
    double left = gmis::cost_of(output.counters(), gmis::vertex_costs) - gmis::vertex_costs.ray;
    for (std::size_t i = 0; i < log.records().size(); ++i, ++vertices) {
      const auto& record = log.records()[i];
      REQUIRE(record.place == i);
      REQUIRE(record.pixel == pixel);
      REQUIRE(glm::dot(record.normal, record.position) < 0);
      // Every vertex of the furnace scatters: vertex i is the vertex t = i + 2 of its paths, counted from the camera.
      std::array<double, 4> sums{};
      for (const auto& one : output.records()) {
        const double value = static_cast<double>(one.value) * static_cast<double>(one.weight);
        const int t = one.id.t - 2 - static_cast<int>(i);
        if (t == 0 && one.id.technique == gmis::Technique::next_event) sums[0] += value;
        if (t == 0 && one.id.technique == gmis::Technique::connect) sums[1] += value;
        if (t == 0 && one.id.technique == gmis::Technique::merge) sums[2] += value;
        if (t > 0) sums[3] += value;
      }
      double cost = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        CAPTURE(pixel, i, k);
        CHECK(static_cast<double>(record.values[k] * record.throughput) == Approx(sums[k]).margin(2e-5));
        cost += static_cast<double>(record.costs[k]);
      }
      CHECK(cost == Approx(left).margin(1e-3));
      left = static_cast<double>(record.costs[3]) - gmis::vertex_costs.ray;
    }
  }
  CHECK(vertices > 150);
}

TEST_CASE(
    "Learned counts: the same bits for any number of threads and after a run that was interrupted; a table that pays") {
  // Bright and dark surfaces are what a furnace has not: the eye near the wall makes some pixels much brighter by merging and next events.
  const Scene scene(0.9F, 1.0F, size, 2, {0.0F, 0.0F, 0.9F});
  auto settings = settings_for(gmis::integrators::vcm, gmis_test::seed(81));
  settings.max_depth = 30;
  const auto one = frames<Both>(scene, settings, nullptr, 8);
  CHECK(same_bits(one, frames<Both>(scene, settings, nullptr, 8, gmis::ThreadExecutor(3))));
  auto uniform = settings;
  uniform.vertex_counts = gmis::VertexCounts::uniform;
  CHECK_FALSE(same_bits(one, frames<Both>(scene, uniform, nullptr, 8)));
  gmis::SerialExecutor executor;
  for (const std::uint32_t first : {1U, 3U, 4U, 6U}) {
    CAPTURE(first);
    const auto rest = gmis_test::frames_after_interrupt<Both>(
        scene, settings, first, 8, executor, [](const Both& engine) { CHECK((engine.count_table() != nullptr)); });
    CHECK(same_bits(rest, {one.end() - static_cast<std::ptrdiff_t>(rest.size()), one.end()}));
  }
}

TEST_CASE("Learned counts need one child, where light trees split; an invalid setting says so") {
  const Scene scene(albedo, 1.0F, size, 2);
  auto settings = settings_for(gmis::integrators::vcm, 1);
  settings.light_split = gmis::LightSplit::budgeted;
  settings.counts.camera_children = 2;
  CHECK_THROWS_AS((gmis::Engine<Scene, gmis::SplitTrees>(scene, settings)), std::invalid_argument);
  settings.counts.camera_children = 1;
  CHECK_NOTHROW(gmis::Engine<Scene, gmis::SplitTrees>(scene, settings));
}
