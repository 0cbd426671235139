#include "gmis/render.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <ctime>
#include <limits>
#include <stdexcept>
#include <vector>

#include "gmis/render/thread_executor.hpp"
#include "gmis/result/merging_bias.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using Furnace = gmis_test::FurnaceScene<float>;

constexpr int size = 12;
const Furnace furnace(0.7F, 1.0F, size, 2);

/// Counts of `vcm` that nothing chooses, so that an engine built by hand makes the same picture.
gmis::RenderRequest request(std::uint32_t iterations) {
  gmis::RenderRequest result;
  result.settings.max_depth = 4;
  result.settings.radius = 0.05;
  result.settings.seed = gmis_test::seed(11);
  result.budget.iterations = iterations;
  result.rejection_limit.share = 1e-2;  // a few rays graze the wall, in float
  return result;
}

/// The film that a loop written by hand makes.
gmis::Film<float> by_hand(const gmis::RenderSettings& settings, int first, int last, int step) {
  gmis::Engine<Furnace> engine(furnace, settings);
  gmis::Film<float> film({size, size});
  gmis::SerialExecutor executor;
  for (int i = 1; i <= last; ++i) {
    engine.iterate(executor);
    if (i >= first && (i - first) % step == 0) film.add_iteration(engine.frame());
  }
  return film;
}

double sum_of(const gmis::Picture& picture) {
  double sum = 0;
  for (const float value : picture.values) sum += static_cast<double>(value);
  return sum;
}

/// Raises the flag when the third iteration begins to trace its camera rows.
struct Stopping : gmis::ThreadExecutor {
  explicit Stopping(std::atomic<bool>& flag_to_set) : gmis::ThreadExecutor(2), flag(flag_to_set) {}
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    // Of all loops, those over the camera's rows alone have this count.
    if (count == static_cast<std::size_t>(size) && ++camera_loops == 3) flag = true;
    gmis::ThreadExecutor::parallel_for(count, work);
  }
  std::atomic<bool>& flag;
  int camera_loops = 0;
};

/// Counts loops, and raises the flag at the start of one of them, counted from 1.
struct StoppingAtLoop : gmis::ThreadExecutor {
  explicit StoppingAtLoop(std::atomic<bool>& flag_to_set, int loop = 0)
      : gmis::ThreadExecutor(2), flag(flag_to_set), stops_at(loop) {}
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    if (++loops == stops_at) flag = true;
    gmis::ThreadExecutor::parallel_for(count, work);
  }
  std::atomic<bool>& flag;
  int stops_at, loops = 0;
};

/// Takes at least 10 ms of processor time for each loop, and knows what they took together.
struct Slow : gmis::SerialExecutor {
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    const std::clock_t start = std::clock();
    const auto begin = std::chrono::steady_clock::now();
    gmis::SerialExecutor::parallel_for(count, work);
    while (static_cast<double>(std::clock() - start) < 1e-2 * CLOCKS_PER_SEC) {
    }
    cpu_seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    wall_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ++loops;
  }
  int loops = 0;
  double cpu_seconds = 0, wall_seconds = 0;
};

/// The iterations after which the stated error is another one than before.
std::vector<std::uint32_t> iterations_with_estimate(gmis::RenderRequest asked) {
  std::vector<std::uint32_t> found;
  double before = 0.0;
  asked.on_iteration = [&](const gmis::RunState& state) {
    if (state.relative_error != before) found.push_back(state.iterations);
    before = state.relative_error;
  };
  gmis::SerialExecutor executor;
  static_cast<void>(gmis::Render(furnace, asked).run(executor));
  return found;
}

}  // namespace

TEST_CASE("a rendering has the bits of a loop written by hand, for any number of threads") {
  gmis::RenderRequest all = request(6);
  all.halves = true;
  const gmis::Picture expected = picture_of(by_hand(all.settings, 1, 6, 1));
  const gmis::Picture odd = picture_of(by_hand(all.settings, 1, 6, 2)),
                      even = picture_of(by_hand(all.settings, 2, 6, 2));
  gmis::SerialExecutor serial;
  const gmis::RenderResult alone = gmis::Render(furnace, all).run(serial);
  CHECK(alone.picture.values == expected.values);
  CHECK(alone.half_a.values == odd.values);
  CHECK(alone.half_b.values == even.values);
  CHECK(alone.iterations == 6);
  CHECK(alone.stopped_by == gmis::StopReason::iterations);
  CHECK(alone.is_trustworthy);
  CHECK(alone.log.back().iteration == 6);
  CHECK_FALSE(alone.error.has_value());
  gmis::ThreadExecutor threads(3);
  CHECK(gmis::Render(furnace, all).run(threads).picture.values == expected.values);
}

TEST_CASE("an interrupt while the error is estimated leaves nothing of the estimate out") {
  gmis::RenderRequest four = request(4);
  four.intervals = true;
  std::atomic<bool> interrupt = false;
  StoppingAtLoop never(interrupt);
  const gmis::RenderResult expected = gmis::Render(furnace, four).run(never);
  REQUIRE(expected.error.has_value());
  REQUIRE(expected.error->relative_error > 0.0);

  // The last loops are those of the estimate: rows, what is around rare samples, rows with those.
  for (const int before_the_last : {2, 1, 0}) {
    interrupt = false;
    gmis::RenderRequest longer = request(6);
    longer.intervals = true;
    longer.interrupt = &interrupt;
    StoppingAtLoop executor(interrupt, never.loops - before_the_last);
    const gmis::RenderResult result = gmis::Render(furnace, longer).run(executor);
    CHECK(interrupt.load());
    CHECK(result.iterations == 4);
    CHECK(result.stopped_by == gmis::StopReason::interrupt);
    REQUIRE(result.error.has_value());
    CHECK(result.error->relative_error == expected.error->relative_error);
    CHECK(result.log.back().estimated_error == expected.log.back().estimated_error);
    CHECK(result.picture.values == expected.picture.values);
  }
}

TEST_CASE("in double, and with the counts that a pilot chooses, the furnace has its closed form") {
  const gmis_test::FurnaceScene<double> scene(0.5, 2.0, 10, 1);
  gmis::RenderSettings settings;
  settings.max_depth = 3;
  settings.radius = 0.05;
  settings.seed = gmis_test::seed(5);
  constexpr int iterations = 48;
  gmis::RenderRequest automatic = gmis::automatic_request(scene, {.iterations = iterations}, 1, settings);
  CHECK(automatic.candidates.size() > 10);
  CHECK(automatic.expected_iterations == iterations);
  // The values of each iteration by itself, of every pixel and last of the picture: from the means
  // so far, which are shown after each.
  std::vector<gmis_test::Series> pixels(101);
  std::vector<double> sums(100);
  const auto take_in = [&](const gmis::Picture& means_so_far) {
    REQUIRE(means_so_far.values.size() == sums.size());
    const auto count = static_cast<double>(pixels[0].count() + 1);
    double mean = 0;
    for (std::size_t p = 0; p < sums.size(); ++p) {
      const double sum = count * static_cast<double>(means_so_far.values[p]);
      pixels[p].add(sum - sums[p]);
      mean += (sum - sums[p]) / static_cast<double>(sums.size());
      sums[p] = sum;
    }
    pixels.back().add(mean);
  };
  automatic.on_picture = take_in;
  automatic.seconds_between_pictures = 0;
  gmis::ThreadExecutor executor(2);
  const gmis::RenderResult result = gmis::Render(scene, automatic).run(executor);
  take_in(result.picture);
  REQUIRE(result.choice.has_value());
  CHECK(result.choice->chosen.has_value());
  CHECK(result.counts == result.choice->forecasts[*result.choice->chosen].counts);
  REQUIRE(result.error.has_value());
  // L (1 + a + a²) = 3.5 in every pixel. Student's t over the iterations; a false alarm of all
  // pixels and the picture together in a thousandth of the seeds. Merging lacks at most the share
  // r²/8 of the 1.5 that are reflected (transport/furnace.cpp).
  const double expected = 2.0 * (1 + 0.5 + 0.25), bias = 0.05 * 0.05 / 8 * 1.5;
  gmis_test::Family family(1e-3, pixels.size());
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    REQUIRE(pixels[p].count() == iterations);
    CAPTURE(p, pixels[p].mean(), pixels[p].standard_error());
    const double by_chance = family.limit(iterations) * pixels[p].standard_error();
    CHECK(std::abs(pixels[p].mean() - expected) < by_chance + bias);
  }
  CHECK(family.is_complete());
  CHECK(6.0 * pixels.back().standard_error() < 0.02 * expected);  // 2 % of the picture would show
  // What the result says of itself: the mean of the picture, and how its pixels vary.
  CHECK(result.estimate.mean == Approx(pixels.back().mean()).epsilon(1e-5));
  double variance = 0;
  for (std::size_t p = 0; p < 100; ++p) variance += gmis::square(pixels[p].standard_error()) / 100;
  CHECK(result.estimate.variance == Approx(variance).epsilon(1e-3));
}

TEST_CASE("pictures of techniques, path classes and lights add up to the picture") {
  gmis::RenderRequest kept = request(4);
  kept.techniques = kept.class_pictures = kept.light_pictures = true;
  kept.settings.path_classes = gmis::PathClassSet::all();
  kept.crop = gmis::PixelBounds{{2, 3}, {9, 8}};
  gmis::SerialExecutor executor;
  const gmis::RenderResult result = gmis::Render(furnace, kept).run(executor);
  CHECK(result.picture.size == glm::ivec2(7, 5));
  CHECK(result.techniques.size() >= 8);
  REQUIRE_FALSE(result.classes.classes.empty());
  REQUIRE(result.by_light.size() == 1);  // the scene has no groups
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      double techniques = 0, classes = 0;
      for (const auto& one : result.techniques) techniques += static_cast<double>(one.weighted.at(x, y, 0));
      for (const auto& one : result.classes.classes) classes += static_cast<double>(one.picture.at(x, y, 0));
      // Rounding of sums of at most 4 iterations with some 50 contributions, in float.
      CHECK(techniques == Approx(result.picture.at(x, y, 0)).epsilon(1e-4));
      CHECK(classes == Approx(result.picture.at(x, y, 0)).epsilon(1e-4));
      CHECK(result.by_light[0].picture.at(x, y, 0) == Approx(result.picture.at(x, y, 0)).epsilon(1e-4));
    }
  double cost = result.classes.unattributed_cost;
  for (const auto& one : result.classes.classes) cost += one.cost;
  CHECK(cost == Approx(1.0));
}

TEST_CASE("a crop has the bits of the whole picture there") {
  gmis::RenderRequest part = request(3);
  gmis::SerialExecutor executor;
  const gmis::Picture whole = gmis::Render(furnace, part).run(executor).picture;
  part.crop = gmis::PixelBounds{{-4, 5}, {6, 40}};  // clipped to the frame
  const gmis::Picture cropped = gmis::Render(furnace, part).run(executor).picture;
  REQUIRE(cropped.size == glm::ivec2(6, size - 5));
  for (int y = 0; y < cropped.size.y; ++y)
    for (int x = 0; x < cropped.size.x; ++x) CHECK(cropped.at(x, y, 0) == whole.at(x, y + 5, 0));
}

TEST_CASE("callbacks come between iterations, and the log ends with the last one") {
  gmis::RenderRequest told = request(21);
  told.intervals = true;
  const gmis::Picture reference = picture_of(by_hand(told.settings, 1, 40, 1));
  told.reference = reference.values;
  std::vector<std::uint32_t> iterations;
  std::vector<gmis::ConvergencePoint> points;
  std::vector<double> pictures;
  told.on_iteration = [&](const gmis::RunState& state) { iterations.push_back(state.iterations); };
  told.on_log = [&](const gmis::ConvergencePoint& point) { points.push_back(point); };
  told.on_picture = [&](const gmis::Picture& picture) { pictures.push_back(sum_of(picture)); };
  told.seconds_between_pictures = 0;
  gmis::SerialExecutor executor;
  const gmis::RenderResult result = gmis::Render(furnace, told).run(executor);
  REQUIRE(iterations.size() == 21);
  CHECK(iterations.front() == 1);
  CHECK(iterations.back() == 21);
  CHECK(pictures.size() == 20);  // the last picture is in the result
  REQUIRE(points.size() == result.log.size());
  CHECK(points.back().iteration == 21);
  CHECK(points.back().reference_error.value_or(0) > 0);
  REQUIRE(result.error.has_value());
  CHECK(result.error->relative_error == result.log.back().estimated_error);
  REQUIRE(result.prices.has_value());
  CHECK(result.prices->prices.size() == gmis::PriceTable::usual_errors.size() + 1);
}

TEST_CASE("estimates of the error are part of the stated time") {
  gmis::RenderRequest timed = request(6);
  timed.intervals = true;
  Slow executor, plain;
  const gmis::RenderResult result = gmis::Render(furnace, timed).run(executor);
  timed.intervals = false;
  static_cast<void>(gmis::Render(furnace, timed).run(plain));
  REQUIRE(executor.loops > plain.loops);
  const double tick = 1e-5;  // of the clocks
  CHECK(result.cpu_seconds >= executor.cpu_seconds - tick);
  CHECK(result.wall_seconds >= executor.wall_seconds - tick);
  CHECK(result.log.back().cpu_seconds >= executor.cpu_seconds - tick);
}

TEST_CASE("the error is estimated for the log, and as soon as it may be down to its limit") {
  using Iterations = std::vector<std::uint32_t>;
  gmis::RenderRequest logged = request(40);
  logged.intervals = true;
  CHECK(iterations_with_estimate(logged) == Iterations{4, 6, 8, 12, 16, 24, 32});
  // Far from the limit, no more often; near it, eight times a doubling, but not before an estimate
  // may end the run.
  logged.budget.relative_error = 1e-6;
  CHECK(iterations_with_estimate(logged) == Iterations{4, 6, 8, 12, 16, 24, 32});
  logged.budget.relative_error = 1e6;
  CHECK(iterations_with_estimate(logged) == Iterations{4, 6, 8});
}

TEST_CASE("limits: an error, an interrupt, too many rejections") {
  gmis::SerialExecutor executor;
  gmis::RenderRequest by_error = request(100'000);
  by_error.budget.relative_error = 0.05;
  const gmis::RenderResult exact = gmis::Render(furnace, by_error).run(executor);
  CHECK(exact.stopped_by == gmis::StopReason::error);
  REQUIRE(exact.error.has_value());
  CHECK(exact.error->relative_error <= 0.05);

  std::atomic<bool> interrupt{false};
  gmis::RenderRequest open_ended = request(100'000);
  open_ended.interrupt = &interrupt;
  open_ended.on_iteration = [&](const gmis::RunState& state) { interrupt = state.iterations == 3; };
  const gmis::RenderResult stopped = gmis::Render(furnace, open_ended).run(executor);
  CHECK(stopped.stopped_by == gmis::StopReason::interrupt);
  CHECK(stopped.iterations == 3);

  // With an executor that stops, the iteration under way is left out: what stays has the bits of 2
  // iterations.
  interrupt = false;
  open_ended.on_iteration = nullptr;
  Stopping stopping(interrupt);
  const gmis::RenderResult cut = gmis::Render(furnace, open_ended).run(stopping);
  CHECK(cut.stopped_by == gmis::StopReason::interrupt);
  CHECK(cut.iterations == 2);
  CHECK(cut.picture.values == picture_of(by_hand(open_ended.settings, 1, 2, 1)).values);

  const Furnace broken(0.7F, std::numeric_limits<float>::quiet_NaN(), size, 2);
  const gmis::RenderResult rejected = gmis::Render(broken, request(100'000)).run(executor);
  CHECK(rejected.stopped_by == gmis::StopReason::rejected);
  CHECK_FALSE(rejected.is_trustworthy);
  CHECK_FALSE(rejected.rejected_paths.empty());
}

TEST_CASE("several renderings take turns") {
  gmis::Render a(furnace, request(5)), b(furnace, request(5));
  gmis::SerialExecutor executor;
  for (int i = 0; i < 5; ++i) {
    REQUIRE(a.advance(executor));
    if (i < 3) REQUIRE(b.advance(executor));
  }
  CHECK(a.reason_to_stop() == gmis::StopReason::iterations);
  CHECK_FALSE(b.reason_to_stop().has_value());
  a.finish_log();
  CHECK(a.picture().values == picture_of(by_hand(request(5).settings, 1, 5, 1)).values);
  CHECK(b.picture().values == picture_of(by_hand(request(5).settings, 1, 3, 1)).values);
}

TEST_CASE("a request that means nothing is refused in words") {
  gmis::RenderRequest wrong = request(1);
  wrong.settings.alpha = 2;
  CHECK_THROWS_AS(gmis::Render(furnace, wrong), std::invalid_argument);
  CHECK(gmis::automatic_request(furnace, {}).budget.iterations == 64U);
  CHECK(gmis::automatic_request(furnace, {}).settings.sampler == gmis::Sampler::sobol);
  CHECK(gmis::automatic_request(furnace, {}, 1, {}).settings.sampler == gmis::Sampler::independent);
  CHECK_FALSE(gmis::automatic_request(furnace, {.seconds = 2.0}).budget.iterations.has_value());
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  const gmis::RenderRequest endless = gmis::automatic_request(furnace, {.seconds = no_number});
  CHECK(endless.expected_iterations >= 1);
  CHECK_THROWS_AS(gmis::Render(furnace, endless), std::invalid_argument);
}
