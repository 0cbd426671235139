#include "gmis/transport/pixel_counts/pixel_counts.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/state_archive.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/render/thread_executor.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/pixel_counts/pixel_count_learner.hpp"
#include "gmis/transport/replay/replay.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/continued_run.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

// Numbers of camera subpaths that are functions of the pixel.

namespace {

using Scene = gmis_test::FurnaceScene<float>;
using Both = gmis::Engine<Scene>;
using OneSide = gmis::PathTracer<Scene>;

constexpr int size = 12;
constexpr std::size_t pixels = size * size;

gmis::RenderSettings settings_for(const gmis::SampleCounts& counts, std::uint64_t seed,
                                  gmis::Sampler sampler = gmis::Sampler::independent) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.seed = seed;
  settings.sampler = sampler;
  settings.max_depth = 5;
  settings.radius = 0.3;
  settings.pixel_counts = gmis::PixelCounts::learned;
  return settings;
}

gmis::PixelCountTable random_table(gmis::Philox& source) {
  std::vector<std::uint8_t> counts(pixels);
  for (std::uint8_t& count : counts)
    count = static_cast<std::uint8_t>(1 + static_cast<int>(gmis::uniform<float>(source) * 8));
  return gmis::PixelCountTable(counts);
}

std::vector<float> frames(const Scene& scene, const gmis::RenderSettings& settings, const gmis::PixelCountTable* table,
                          int iterations, auto executor) {
  Both engine(scene, settings);
  if (table != nullptr) engine.use_pixel_counts(*table);
  std::vector<float> all;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    all.insert(all.end(), engine.frame().begin(), engine.frame().end());
  }
  return all;
}

/// `run` after an interruption: its state is written and read again, for a frame of `frame_size`
/// pixels.
gmis::LearnedPixelCounts interrupted(gmis::LearnedPixelCounts& run, const gmis::CropPixels& crop,
                                     std::size_t frame_size) {
  gmis::StateWriter writer;
  const auto write = [&](auto&... parts) { writer(parts...); };
  run.exchange_state(write, frame_size);
  gmis::StateReader reader(writer.bytes());
  const auto read = [&](auto&... parts) { reader(parts...); };
  gmis::LearnedPixelCounts next(crop);
  next.exchange_state(read, frame_size);
  REQUIRE((reader.is_at_end() && !reader.is_broken()));
  return next;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("A run learns the numbers once, and knows them and when it did after an interruption") {
  constexpr std::size_t side = 8, count = side * side;
  const gmis::CropPixels crop{side, side, 0, side, side};
  constexpr std::uint32_t learns = gmis::PixelCountLearner::iterations;
  // Subpaths of a quarter of the pixels differ much: with a table. They never differ: without.
  for (const bool gains : {true, false})
    for (const std::uint32_t interruption : {0U, 2U, learns, learns + 1}) {
      CAPTURE(gains, interruption);
      gmis::LearnedPixelCounts run(crop);
      std::vector<float> frame(count, 1.0F);
      for (std::uint32_t i = 1; i <= learns + 2; ++i) {
        if (i == interruption + 1) run = interrupted(run, crop, count);
        CHECK(run.is_learning() == (i <= learns));
        CHECK((run.table() == nullptr || i > learns));
        const gmis::PixelSchedule schedule = run.schedule(i);
        CHECK(schedule.uniform == (i <= learns ? gmis::PixelCountLearner::subpaths : 1));
        if (!run.is_learning()) continue;
        for (std::size_t pixel = 0; pixel < count; ++pixel) {
          const bool is_noisy = gains && pixel % side < 4 && pixel / side < 4;
          run.learner().note(pixel, is_noisy ? (i % 2 == 0 ? 2.0 : -2.0) : 0.0, 2.0);
          frame[pixel] = is_noisy ? (i % 2 == 0 ? 2.0F : 0.1F) : (i % 2 == 0 ? 1.1F : 0.9F);
        }
        run.end_iteration(std::span<const float>(frame), 2.0 * count, i);
      }
      REQUIRE((run.table() != nullptr) == gains);
      if (gains) CHECK((*run.table())[0] > (*run.table())[count - 1]);
      // Iterations of the same replication before the numbers were known.
      CHECK(run.schedule(learns + gmis::sobol_replications).before == 1);
      CHECK(run.schedule(gmis::sobol_replications).before == 0);
    }
  gmis::LearnedPixelCounts given(crop);
  given.use(gmis::PixelCountTable(std::vector<std::uint8_t>(count, 7)), 0);
  CHECK_FALSE(given.is_learning());
  CHECK((*interrupted(given, crop, count).table())[0] == 7);
  CHECK(interrupted(given, crop, count - 1).table() == nullptr);  // as if the archive were broken
  CHECK_FALSE(gmis::LearnedPixelCounts().is_learning());
  CHECK(gmis::LearnedPixelCounts().schedule(9).uniform == 1);
}

TEST_CASE("A pixel is the mean of its subpaths, and its first subpath is the one that it would have alone") {
  const Scene scene(0.6F, 1.0F, size, 2);
  for (const auto sampler : {gmis::Sampler::independent, gmis::Sampler::sobol}) {
    gmis::Philox source(gmis_test::seed(11), 1, 0);
    const gmis::PixelCountTable table = random_table(source);
    auto settings = settings_for(gmis::integrators::pt, gmis_test::seed(12), sampler);
    OneSide engine(scene, settings);
    engine.use_pixel_counts(table);
    settings.pixel_counts = gmis::PixelCounts::uniform;
    OneSide alone(scene, settings);
    gmis::SerialExecutor executor;
    engine.iterate(executor);
    alone.iterate(executor);
    const auto context = engine.context();
    gmis::FilmOutput<float> output;
    gmis::CameraSubpath<OneSide::Context, gmis::FilmOutput<float>> subpath(context, output);
    std::uint64_t subpaths = 0, different = 0;
    for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
      double sum = 0;
      for (std::uint32_t k = 0; k < table[pixel]; ++k, ++subpaths) {
        output.clear();
        output.begin_pixel(pixel);
        subpath.trace({static_cast<int>(pixel) % size, static_cast<int>(pixel) / size}, pixel,
                      OneSide::numbers_of(context, gmis::PathKind::camera, pixel, k));
        const auto value = static_cast<double>(output.take_pixel());
        if (k == 0) CHECK(output.take_pixel() == alone.frame()[pixel]);
        if (k == 1 && output.take_pixel() != alone.frame()[pixel]) ++different;
        sum += value;
      }
      CHECK(static_cast<double>(engine.frame()[pixel]) == Approx(sum / table[pixel]).epsilon(1e-5));
      CHECK(gmis::replay(engine, gmis::PathKind::camera, pixel).pixel_sum == engine.frame()[pixel]);
    }
    CHECK(engine.counters().camera_paths == subpaths);
    CHECK(different > pixels / 2);  // seven pixels in eight have a second subpath, with numbers of its own
  }
}

TEST_CASE("Any numbers of subpaths leave the mean of every technique as it is") {
  const Scene scene(0.6F, 1.0F, size, 2);
  constexpr int iterations = 400, tables = 3;
  const double level = gmis::sidak_level(1e-3, gmis::technique_count * tables);
  gmis::SerialExecutor executor;
  const auto sums = [&](Both& engine) {
    engine.keep_contributions(true);
    std::array<std::array<double, 2>, gmis::technique_count> mean_and_error{};
    for (int i = 0; i < iterations; ++i) {
      engine.iterate(executor);
      std::array<double, gmis::technique_count> one{};
      engine.for_each_contribution([&](const gmis::Contribution<float>& made) {
        one[static_cast<std::size_t>(made.id.technique)] +=
            static_cast<double>(made.value) * static_cast<double>(made.weight);
      });
      for (std::size_t k = 0; k < one.size(); ++k) {
        mean_and_error[k][0] += one[k] / iterations;
        mean_and_error[k][1] += one[k] * one[k] / iterations;
      }
    }
    for (auto& [mean, error] : mean_and_error) error = (error - mean * mean) / (iterations - 1.0);
    return mean_and_error;
  };
  auto plain = settings_for(gmis::integrators::vcm, gmis_test::seed(21));
  plain.pixel_counts = gmis::PixelCounts::uniform;
  Both without(scene, plain);
  const auto expected = sums(without);
  for (std::uint64_t t = 0; t < tables; ++t) {
    gmis::Philox source(gmis_test::seed(22), 1, static_cast<std::uint32_t>(t));
    Both with(scene, settings_for(gmis::integrators::vcm, gmis_test::seed(23 + t)));
    with.use_pixel_counts(random_table(source));
    const auto made = sums(with);
    for (std::size_t k = 0; k < gmis::technique_count; ++k) {
      const double error = std::sqrt(expected[k][1] + made[k][1]);
      CAPTURE(t, k, expected[k][0], made[k][0], error);
      REQUIRE(error > 0);
      CHECK(gmis::student_t_p_value((made[k][0] - expected[k][0]) / error, iterations - 1.0) > level);
    }
  }
}

TEST_CASE("The subpaths of a pixel take the points of its sequences one after the other") {
  const Scene scene(0.6F, 1.0F, size, 2);
  gmis::SerialExecutor executor;
  gmis::Philox source(gmis_test::seed(31), 1, 0);
  const gmis::PixelCountTable table = random_table(source);
  for (const std::uint32_t earlier : {0U, 21U})  // iterations of another engine, with a subpath a pixel
    for (const bool learns : {true, false}) {
      CAPTURE(earlier, learns);
      std::array<std::array<std::uint64_t, pixels>, gmis::sobol_replications> taken{};
      for (std::uint32_t i = 1; i <= earlier; ++i)
        for (std::uint64_t& of_pixel : taken[(i - 1) % gmis::sobol_replications]) ++of_pixel;
      for (std::uint32_t i = earlier + 1; i <= earlier + 40; ++i) {
        Both engine(scene, settings_for(gmis::integrators::pt_lt, gmis_test::seed(32), gmis::Sampler::sobol));
        engine.continue_after(earlier);
        if (!learns) engine.use_pixel_counts(table);
        engine.prepare_replay(executor, i);
        const gmis::PixelSchedule schedule = engine.context().keys.schedule;
        const bool is_learning = learns && i <= earlier + gmis::PixelCountLearner::iterations;
        CHECK(schedule.uniform == (is_learning ? gmis::PixelCountLearner::subpaths : 1));
        CHECK((schedule.table != nullptr) == !(is_learning || (learns && engine.pixel_counts() == nullptr)));
        for (const std::size_t pixel : {0U, 77U, 143U}) {
          CAPTURE(i, pixel);
          std::uint64_t& of_pixel = taken[(i - 1) % gmis::sobol_replications][pixel];
          CHECK(schedule.first_point(pixel) == of_pixel);
          of_pixel += is_learning ? 1 : schedule.count(pixel);
        }
      }
    }
}

TEST_CASE("Numbers of subpaths follow the variance that subpaths do not share") {
  // The right quarter of the picture has noise of its own in each subpath, the lower half noise
  // that all subpaths of a pixel share.
  constexpr std::size_t width = 40, height = 30;
  const gmis::CropPixels crop{width, height, 0, width, height};
  gmis::Philox source(gmis_test::seed(41), 1, 0);
  const auto normal = [&] {
    const double u = 1 - gmis::uniform<double>(source), v = gmis::uniform<double>(source);
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * gmis::pi<double> * v);
  };
  for (const double own : {0.0, 0.5}) {
    CAPTURE(own);
    gmis::PixelCountLearner learner(crop);
    for (std::uint32_t i = 0; i < gmis::PixelCountLearner::iterations; ++i) {
      std::vector<float> frame(width * height);
      for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x) {
          const double shared = y >= height / 2 ? 0.1 * normal() : 0.0;
          const double noise = x >= 3 * width / 4 ? own : 0.02 * own;
          const double first = 1 + shared + noise * normal(), second = 1 + shared + noise * normal();
          learner.note(y * width + x, second - first, 2 * 10.0);
          frame[y * width + x] = static_cast<float>(0.5 * (first + second));
        }
      learner.end_iteration(std::span<const float>(frame), 2 * 10.0 * width * height + 1000.0);
    }
    const auto table = learner.table();
    REQUIRE(table.has_value() == (own > 0));
    if (!table) continue;
    CHECK(table->fits(width * height));
    double left = 0, right = 0, lower = 0, upper = 0;
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        const double n = (*table)[y * width + x];
        if (x + 3 < 3 * width / 4) left = std::max(left, n);
        if (x >= 3 * width / 4 + 3) right += n, (y < height / 2 ? upper : lower) += n;
      }
    CHECK(left == 1);
    CHECK(right / (height * (width / 4 - 3)) > 2);
    CHECK(std::abs(lower / upper - 1) < 0.25);  // shared noise asks for none
  }
}

TEST_CASE("What the subpaths of an iteration share is no reason for more of them") {
  // Three fifths of the variance of one subpath are its own, and half of the cost is not that of
  // subpaths. Two subpaths make the variance 0.7 times as large and the cost 1.5 times: no gain.
  // Were all variance divided, it would be 0.5 × 1.5.
  constexpr std::size_t width = 40, height = 30;
  gmis::Philox source(gmis_test::seed(45), 1, 0);
  const auto normal = [&] {
    const double u = 1 - gmis::uniform<double>(source), v = gmis::uniform<double>(source);
    return 0.3 * std::sqrt(-2 * std::log(u)) * std::cos(2 * gmis::pi<double> * v);
  };
  gmis::PixelCountLearner learner(gmis::CropPixels{width, height, 0, width, height});
  for (std::uint32_t i = 0; i < gmis::PixelCountLearner::iterations; ++i) {
    std::vector<float> frame(width * height);
    for (std::size_t p = 0; p < frame.size(); ++p) {
      const double shared = 1 + std::sqrt(0.4) * normal(), first = std::sqrt(0.6) * normal(),
                   second = std::sqrt(0.6) * normal();
      learner.note(p, second - first, 2 * 10.0);
      frame[p] = static_cast<float>(shared + 0.5 * (first + second));
    }
    learner.end_iteration(std::span<const float>(frame), (2 * 10.0 + 10.0) * width * height);
  }
  CHECK_FALSE(learner.table().has_value());
}

TEST_CASE("Learned numbers of subpaths: the same bits for any number of threads and after a run that was interrupted") {
  // The iterations that are learned from, and what follows, here without a table: more subpaths
  // gain little in a furnace.
  const Scene scene(0.9F, 1.0F, size, 2, {0.0F, 0.0F, 0.9F});
  for (const auto sampler : {gmis::Sampler::independent, gmis::Sampler::sobol}) {
    auto settings = settings_for(gmis::integrators::pt_lt, gmis_test::seed(51), sampler);
    settings.max_depth = 30;
    const auto one = frames(scene, settings, nullptr, 12, gmis::SerialExecutor());
    CHECK(same_bits(one, frames(scene, settings, nullptr, 12, gmis::ThreadExecutor(3))));
    auto uniform = settings;
    uniform.pixel_counts = gmis::PixelCounts::uniform;
    CHECK_FALSE(same_bits(one, frames(scene, uniform, nullptr, 12, gmis::SerialExecutor())));
    gmis::SerialExecutor executor;
    for (const std::uint32_t first : {1U, 3U, 4U, 9U}) {
      CAPTURE(first);
      const auto rest =
          gmis_test::frames_after_interrupt<Both>(scene, settings, first, 12, executor, [](const Both&) {});
      CHECK(same_bits(rest, {one.end() - static_cast<std::ptrdiff_t>(rest.size()), one.end()}));
    }
  }
}

TEST_CASE("A table with the number 1 everywhere changes no bit") {
  const Scene scene(0.6F, 1.0F, size, 2);
  for (const auto sampler : {gmis::Sampler::independent, gmis::Sampler::sobol}) {
    auto settings = settings_for(gmis::integrators::vcm, gmis_test::seed(61), sampler);
    const gmis::PixelCountTable ones(std::vector<std::uint8_t>(pixels, 1));
    const auto with = frames(scene, settings, &ones, 10, gmis::SerialExecutor());
    settings.pixel_counts = gmis::PixelCounts::uniform;
    CHECK(same_bits(with, frames(scene, settings, nullptr, 10, gmis::SerialExecutor())));
  }
  CHECK_FALSE(gmis::PixelCountTable(std::vector<std::uint8_t>(pixels, 0)).fits(pixels));
  CHECK_FALSE(gmis::PixelCountTable(std::vector<std::uint8_t>(pixels, 9)).fits(pixels));
  CHECK_FALSE(gmis::PixelCountTable(std::vector<std::uint8_t>(pixels - 1, 1)).fits(pixels));
}
