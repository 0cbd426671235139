#include "gmis/render/ranks.hpp"

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/render.hpp"
#include "gmis/render/join_runs.hpp"
#include "gmis/render/thread_executor.hpp"
#include "gmis/transport/splitting/gmis_engines.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"
#include "support/thread_ranks.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using Furnace = gmis_test::FurnaceScene<float>;
using Run = gmis::RenderRun<float>;

const Furnace furnace(0.7F, 1.0F, 9, 2);

/// A request, and whether light trees split.
struct Case {
  std::string name;
  gmis::RenderRequest request;
  bool splits = false;
};

gmis::RenderRequest request_with(const gmis::SampleCounts& counts, std::uint32_t iterations = 13) {
  gmis::RenderRequest request;
  request.settings.max_depth = 4;
  request.settings.radius = 0.1;
  request.settings.seed = gmis_test::seed(31);
  request.settings.counts = counts;
  request.scene_name = "furnace";
  request.budget.iterations = iterations;
  request.intervals = request.halves = true;
  return request;
}

/// A pilot chooses, and disk and gain of merging are chosen anew after 4 and 32 iterations.
gmis::RenderRequest automatic(std::uint32_t iterations = 37) {
  gmis::RenderSettings settings = request_with({}).settings;
  gmis::RenderRequest request = gmis::automatic_request(furnace, {.iterations = iterations}, 1, settings);
  // Candidates that all merge, so that there is something to adapt.
  std::erase_if(request.candidates, [](const gmis::SampleCounts& one) { return !one.merges; });
  request.scene_name = "furnace";
  request.intervals = request.halves = true;
  return request;
}

std::vector<Case> cases() {
  namespace integrators = gmis::integrators;
  std::vector<Case> all{{"pt", request_with(integrators::pt)},
                        {"lt", request_with(integrators::lt)},
                        {"bpt", request_with(integrators::bpt)},
                        {"ppm", request_with(integrators::ppm)},
                        {"bpm", request_with(integrators::bpm)},
                        {"vcm", request_with(integrators::vcm)},
                        {"auto", automatic()}};
  all.push_back({"trees that split", request_with(integrators::vcm), true});
  Case cropped{"a crop", request_with(integrators::vcm)};
  cropped.request.crop = gmis::PixelBounds{{2, 1}, {8, 5}};
  all.push_back(cropped);
  Case independent{"independent samples", request_with(integrators::vcm, 37)};
  independent.request.settings.sampler = gmis::Sampler::independent;
  all.push_back(independent);
  Case drawn{"drawn connections", request_with(integrators::bpt)};
  drawn.request.settings.counts.connections = 1;
  all.push_back(drawn);
  Case limited{"a limit on the error", request_with(integrators::pt, 1000)};
  limited.request.budget.relative_error = 0.02;
  all.push_back(limited);
  return all;
}

gmis::EngineMaker<float> engines(const Case& one) {
  return one.splits ? gmis::gmis_engines(furnace, gmis::GmisSampler{}) : gmis::engines_with_pilot(furnace);
}

/// Raises the flag at the start of an iteration, counted from 1 among those that it renders.
struct StoppingAt : gmis::ThreadExecutor {
  StoppingAt(std::atomic<bool>& flag_to_set, int iteration)
      : gmis::ThreadExecutor(1), flag(flag_to_set), left(iteration) {}
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    if (--left == 0) flag = true;
    gmis::ThreadExecutor::parallel_for(count, work);
  }
  std::atomic<bool>& flag;
  int left;
};

/// The result of a run over this number of ranks, and its checkpoint.
struct Outcome {
  gmis::RenderResult result;
  std::vector<std::byte> checkpoint;
};

Outcome outcome_of(const Case& one, int count, const std::vector<std::byte>& from = {}) {
  Outcome outcome;
  gmis_test::on_ranks(count, [&](const gmis::RanksRef& ranks) {
    gmis::SerialExecutor executor;
    gmis::RenderRequest request = one.request;
    request.ranks = ranks;
    Run run(engines(one), furnace.camera().resolution(), request);
    if (!from.empty()) run.resume(from);
    gmis::RenderResult result = run.run(executor);
    std::vector<std::byte> checkpoint = run.checkpoint();
    if (ranks.is_first()) outcome = {std::move(result), std::move(checkpoint)};
  });
  return outcome;
}

/// Every counter, in the order of their declaration.
auto all_of(const gmis::Counters& counters) {
  static_assert(std::has_unique_object_representations_v<gmis::Counters>);
  return std::bit_cast<std::array<std::uint64_t, sizeof(gmis::Counters) / sizeof(std::uint64_t)>>(counters);
}

void check_same(const gmis::RenderResult& a, const gmis::RenderResult& b) {
  CHECK(a.iterations == b.iterations);
  CHECK(a.stopped_by == b.stopped_by);
  CHECK(a.picture.values == b.picture.values);
  CHECK(a.variance.values == b.variance.values);
  CHECK(a.half_a.values == b.half_a.values);
  CHECK(a.half_b.values == b.half_b.values);
  CHECK(a.estimate.mean == b.estimate.mean);
  CHECK(a.estimate.variance == b.estimate.variance);
  CHECK(a.error->relative_error == b.error->relative_error);
  CHECK(a.error->interval.upper == b.error->interval.upper);
  REQUIRE(a.merging_bias.has_value() == b.merging_bias.has_value());
  if (a.merging_bias) {
    CHECK(a.merging_bias->bound() == b.merging_bias->bound());
    CHECK(a.merging_bias->of_mean == b.merging_bias->of_mean);
    CHECK(a.merging_bias->made_up == b.merging_bias->made_up);
  }
  CHECK(a.counts == b.counts);
  CHECK(a.radius == b.radius);
  CHECK(all_of(a.counters) == all_of(b.counters));
  REQUIRE(a.log.size() == b.log.size());
  for (std::size_t i = 0; i < a.log.size(); ++i) {
    CHECK(a.log[i].iteration == b.log[i].iteration);
    CHECK(a.log[i].estimated_error == b.log[i].estimated_error);
  }
}

}  // namespace

TEST_CASE("A run has the same bits for any number of ranks") {
  for (const Case& one : cases()) {
    const gmis::RenderResult alone = outcome_of(one, 1).result;
    CHECK(alone.estimate.mean > 0);
    CHECK(alone.counters.rays > 0);
    for (const int count : {2, 3, 5, 7}) {
      INFO(one.name << ", " << count << " ranks");
      check_same(outcome_of(one, count).result, alone);
    }
  }
}

TEST_CASE("What the cases above are to show occurs in them") {
  const gmis::RenderResult automatic_run = outcome_of({"auto", automatic()}, 1).result;
  REQUIRE(automatic_run.choice.has_value());
  REQUIRE(automatic_run.choice->chosen.has_value());
  CHECK(automatic_run.counts.merges);
  CHECK(automatic_run.merging_bias->made_up != 0);  // a gain was chosen on the way
  for (const Case& one : cases())
    if (one.request.budget.relative_error) CHECK(outcome_of(one, 1).result.stopped_by == gmis::StopReason::error);
}

TEST_CASE("The checkpoint of two ranks is resumed by three, and by one") {
  for (Case one : cases()) {
    const gmis::RenderResult whole = outcome_of(one, 1).result;
    Case part = one;
    part.request.budget.iterations = 6;
    const Outcome first = outcome_of(part, 2);
    for (const int count : {1, 3}) {
      INFO(one.name << ", resumed by " << count);
      one.request.expected_iterations = 1;  // that of the checkpoint counts
      check_same(outcome_of(one, count, first.checkpoint).result, whole);
    }
  }
}

TEST_CASE("A run with fewer rows than ranks, and one with fewer iterations") {
  Case flat{"one row", request_with(gmis::integrators::vcm, 5)};
  flat.request.crop = gmis::PixelBounds{{0, 3}, {9, 4}};
  check_same(outcome_of(flat, 3).result, outcome_of(flat, 1).result);
  const Case few{"two iterations", request_with(gmis::integrators::vcm, 2)};
  check_same(outcome_of(few, 5).result, outcome_of(few, 1).result);
}

TEST_CASE("Callbacks are called by rank 0 alone, with the whole picture") {
  Case one{"vcm", request_with(gmis::integrators::vcm, 6)};
  int checkpoints = 0, pictures = 0, points = 0;
  std::vector<float> latest;
  std::vector<std::byte> state;
  one.request.seconds_between_pictures = 0;
  one.request.on_checkpoint = [&](std::span<const std::byte> bytes) {
    ++checkpoints;
    state.assign(bytes.begin(), bytes.end());
  };
  one.request.on_picture = [&](const gmis::Picture& picture) {
    ++pictures;
    latest = picture.values;
  };
  one.request.on_log = [&](const gmis::ConvergencePoint&) { ++points; };
  const Outcome outcome = outcome_of(one, 2);
  CHECK(checkpoints == 3);  // after each round
  CHECK(pictures == 2);     // not after the last one
  CHECK(points == 3);       // after iterations 1, 4 and 6
  Case shorter{"vcm", request_with(gmis::integrators::vcm, 4)};
  CHECK(latest == outcome_of(shorter, 1).result.picture.values);
  check_same(outcome_of(one, 1, state).result, outcome.result);
}

TEST_CASE("Rank 0 has the rows of its own again after it has shown the whole picture") {
  std::size_t before = 0, shown = 0, after = 0;
  gmis_test::on_ranks(2, [&](const gmis::RanksRef& ranks) {
    gmis::SerialExecutor executor;
    gmis::RenderRequest request = request_with(gmis::integrators::pt, 4);
    request.ranks = ranks;
    Run run(engines({}), furnace.camera().resolution(), request);
    const bool goes_on = run.advance(executor);
    const std::size_t own = run.film().pixel_count();
    const gmis::Picture picture = run.picture();
    if (goes_on && ranks.is_first()) before = own, shown = picture.values.size(), after = run.film().pixel_count();
  });
  CHECK(before == 45);  // 5 of 9 rows
  CHECK(shown == 81);
  CHECK(after == before);
}

TEST_CASE("The errors in the log against a reference are those of one rank") {
  Case one{"bpt", request_with(gmis::integrators::bpt, 9)};
  const std::vector<float> reference(81, 2.5F);
  one.request.reference = reference;
  const gmis::RenderResult alone = outcome_of(one, 1).result, shared = outcome_of(one, 3).result;
  REQUIRE(alone.log.size() == shared.log.size());
  for (std::size_t i = 0; i < alone.log.size(); ++i) {
    REQUIRE(alone.log[i].reference_error.has_value());
    CHECK(alone.log[i].reference_error == shared.log[i].reference_error);
  }
}

TEST_CASE("Ranks with another run are refused, and the message names the rank and what differs") {
  const auto refusal = [](auto&& change) {
    std::vector<std::string> messages(3);
    gmis_test::on_ranks(3, [&](const gmis::RanksRef& ranks) {
      gmis::RenderRequest request = request_with(gmis::integrators::vcm);
      request.ranks = ranks;
      if (ranks.rank() == 2) change(request);
      messages[static_cast<std::size_t>(ranks.rank())] = gmis_test::message_of(
          [&] { Run run(gmis::engines_with_pilot(furnace), furnace.camera().resolution(), request); });
    });
    CHECK(messages[0] == messages[1]);
    CHECK(messages[0] == messages[2]);
    return messages[0];
  };
  CHECK(refusal([](gmis::RenderRequest&) {}).empty());
  CHECK(refusal([](gmis::RenderRequest& request) { request.scene_name = "kiln"; }) ==
        "rank 2 has another run than rank 0: the scene differs: kiln, not furnace");
  CHECK(refusal([](gmis::RenderRequest& request) { request.settings.max_depth = 5; }) ==
        "rank 2 has another run than rank 0: the greatest depth differs: 5, not 4");
  CHECK(refusal([](gmis::RenderRequest& request) { request.halves = false; }).find("what is kept differs") !=
        std::string::npos);
  const std::string message = gmis_test::message_of([&] {
    gmis_test::on_ranks(2, [&](const gmis::RanksRef& ranks) {
      gmis::RenderRequest request = request_with(gmis::integrators::vcm);
      request.ranks = ranks;
      request.techniques = true;
      Run run(gmis::engines_with_pilot(furnace), furnace.camera().resolution(), request);
    });
  });
  CHECK(message.find("pictures of techniques") != std::string::npos);
}

TEST_CASE("The parts of a run, rendered apart and joined in any order, have the bits of the run") {
  for (const Case& one : cases()) {
    if (one.name == "auto" || one.request.budget.relative_error) continue;
    INFO(one.name);
    const gmis::RenderResult whole = outcome_of(one, 1).result;
    const std::uint32_t length = *one.request.budget.iterations;
    std::vector<std::vector<std::byte>> checkpoints;
    for (const auto& [first, last] : {std::pair{6U, length}, {1U, 2U}, {3U, 5U}}) {
      Case part = one;
      part.request.part = gmis::RunPart{first, last, length};
      Outcome outcome = outcome_of(part, 1);
      CHECK(outcome.result.iterations == last - first + 1);
      if (last == length) {  // killed on the way, and resumed
        Case shorter = part;
        shorter.request.seconds_between_pictures = 0;
        std::vector<std::byte> early;
        shorter.request.on_checkpoint = [&](std::span<const std::byte> bytes) {
          if (early.empty()) early.assign(bytes.begin(), bytes.end());
        };
        (void)outcome_of(shorter, 1);
        outcome = outcome_of(part, 1, early);
      }
      checkpoints.push_back(outcome.checkpoint);
    }
    gmis::RenderResult joined =
        gmis::join_runs<float>(one.request, furnace.camera().resolution(), checkpoints, engines(one).properties);
    CHECK(joined.stopped_by == gmis::StopReason::joined);
    CHECK(joined.joined_seeds == std::vector<std::uint64_t>{gmis_test::seed(31)});
    joined.stopped_by = whole.stopped_by;
    check_same(joined, whole);
  }
}

TEST_CASE("Parts that are missing, there twice or of another run are refused, and the message says which") {
  const Case one{"bpt", request_with(gmis::integrators::bpt, 8)};
  const auto part_of = [&](std::uint32_t first, std::uint32_t last, std::uint32_t of, std::uint64_t seed = 31) {
    Case part = one;
    part.request.settings.seed = gmis_test::seed(seed);
    part.request.part = gmis::RunPart{first, last, of};
    return outcome_of(part, 1).checkpoint;
  };
  const auto refusal = [&](const std::vector<std::vector<std::byte>>& checkpoints) {
    return gmis_test::message_of(
        [&] { return gmis::join_runs<float>(one.request, furnace.camera().resolution(), checkpoints); });
  };
  const auto a = part_of(1, 3, 8), b = part_of(4, 6, 8), c = part_of(7, 8, 8);
  CHECK(refusal({c, a, b}).empty());
  CHECK(refusal({a, c}) == "iterations 4 to 6 of the run are missing");
  CHECK(refusal({a, b}) == "iterations 7 to 8 of the run are missing");
  CHECK(refusal({b, c}) == "iterations 1 to 3 of the run are missing");
  CHECK(refusal({a, b, part_of(6, 8, 8)}) == "iterations 6 to 6 of the run are there twice");
  CHECK(refusal({a, b, part_of(7, 8, 9)}) == "the parts are of runs of different lengths");
  CHECK(refusal({a, b, part_of(7, 8, 8, 32)}) ==
        "checkpoint 3: the seed of this part differs from that of checkpoint 1");
  CHECK(refusal({a, b, outcome_of(one, 1).checkpoint}) ==
        "checkpoint 3: parts of a run are joined with its parts alone");
  Case merging{"auto", automatic()};
  merging.request.part = gmis::RunPart{1, 2, 4};
  CHECK_THROWS_AS(outcome_of(merging, 1), std::invalid_argument);
  Case shared = one;
  shared.request.part = gmis::RunPart{1, 2, 4};
  CHECK_THROWS_AS(outcome_of(shared, 2), std::invalid_argument);
  shared.request.part = gmis::RunPart{3, 2, 4};
  CHECK_THROWS_AS(outcome_of(shared, 1), std::invalid_argument);
}

TEST_CASE("A renderer with a transport of its own: bytes in memory, on docs/many-machines.md") {
  const gmis::RenderRequest request = request_with(gmis::integrators::vcm, 12);
  std::vector<std::vector<std::byte>> received;
  const auto send = [&](const std::vector<std::byte>& bytes) { received.push_back(bytes); };
  gmis::SerialExecutor executor;
  const auto render_part = [&](const gmis::RunPart& part) {
    gmis::RenderRequest task = request;
    task.part = part;
    gmis::Render render(furnace, task);
    render.run(executor);
    send(render.checkpoint());
  };
  for (const std::uint32_t first : {1U, 5U, 9U}) render_part({first, first + 3, 12});
  const auto resolution = furnace.camera().resolution();
  const gmis::RenderResult result = gmis::join_runs<float>(request, resolution, received);
  CHECK(result.picture.values == outcome_of({"vcm", request}, 1).result.picture.values);
}

TEST_CASE("when one rank is stopped all leave out the round, which may hold several iterations of each") {
  const gmis::RenderResult whole = outcome_of({"", request_with(gmis::integrators::pt, 16)}, 1).result;
  gmis_test::on_ranks(2, [&](const gmis::RanksRef& ranks) {
    std::atomic<bool> interrupt = false;
    gmis::RenderRequest request = request_with(gmis::integrators::pt, 40);
    request.ranks = ranks;
    request.intervals = false;  // every loop is an iteration
    if (!ranks.is_first()) request.interrupt = &interrupt;
    // Iterations 17 to 20 are a round; those of rank 1 are its ninth and tenth.
    StoppingAt executor(interrupt, ranks.is_first() ? 0 : 9);
    const gmis::RenderResult result =
        Run(gmis::engines_with_pilot(furnace), furnace.camera().resolution(), request).run(executor);
    if (!ranks.is_first()) return;
    CHECK(result.stopped_by == gmis::StopReason::interrupt);
    CHECK(result.iterations == 16);
    CHECK(result.picture.values == whole.picture.values);
  });
}

TEST_CASE("when a rank is stopped while it estimates the error of its rows, none of them is left out") {
  const gmis::RenderResult whole = outcome_of({"", request_with(gmis::integrators::pt, 4)}, 1).result;
  int loops = 0;
  for (const bool stops : {false, true})
    gmis_test::on_ranks(2, [&](const gmis::RanksRef& ranks) {
      std::atomic<bool> interrupt = false;
      gmis::RenderRequest request = request_with(gmis::integrators::pt, stops ? 40 : 4);
      request.ranks = ranks;
      if (!ranks.is_first()) request.interrupt = &interrupt;
      // The last loop of rank 1 is the estimate after four iterations.
      StoppingAt executor(interrupt, stops && !ranks.is_first() ? loops : 0);
      const gmis::RenderResult result =
          Run(gmis::engines_with_pilot(furnace), furnace.camera().resolution(), request).run(executor);
      if (!stops && !ranks.is_first()) loops = -executor.left;
      if (!stops || !ranks.is_first()) return;
      CHECK(result.stopped_by == gmis::StopReason::interrupt);
      CHECK(result.iterations == 4);
      CHECK(result.error->relative_error == whole.error->relative_error);
      CHECK(result.error->interval.upper == whole.error->interval.upper);
    });
}

TEST_CASE("a firefly is compared with the same pixels, whichever ranks have them") {
  // Stripes higher and lower than what is around them.
  const gmis::PixelBounds picture{{0, 0}, {9, 90}};
  const glm::ivec2 size = picture.upper - picture.lower;
  std::mt19937 source(static_cast<std::uint32_t>(gmis_test::seed(33)));
  std::uniform_real_distribution<float> uniform;
  std::vector<std::vector<float>> frames(21, std::vector<float>(static_cast<std::size_t>(size.x * size.y)));
  for (std::vector<float>& frame : frames)
    for (float& value : frame) value = uniform(source) + (uniform(source) < 0.002F ? 90.0F : 0.0F);
  for (const std::size_t replications : {std::size_t{0}, std::size_t{8}}) {
    const auto means_of = [&](const gmis::PixelBounds& rows) {
      const auto width = static_cast<std::size_t>(size.x);
      gmis::BatchMeans<float> means({size.x, rows.upper.y - rows.lower.y}, replications);
      for (const std::vector<float>& frame : frames)
        means.add_iteration(
            std::span(frame).subspan(static_cast<std::size_t>(rows.lower.y) * width, means.value_count()));
      return means;
    };
    const auto alone = gmis::estimate_error(means_of(picture));
    for (const int count : {1, 2, 3, 5, 7, 40}) {
      std::vector<std::optional<gmis::ErrorEstimate>> estimates(static_cast<std::size_t>(count));
      gmis_test::on_ranks(count, [&](const gmis::RanksRef& ranks) {
        gmis::SerialExecutor executor;
        estimates[static_cast<std::size_t>(ranks.rank())] = gmis::detail::error_over_ranks(
            ranks, picture, means_of(gmis::detail::stripe_of(picture, ranks.rank(), count)), executor);
      });
      for (const auto& estimate : estimates) {
        CAPTURE(replications, count, &estimate - estimates.data());
        CHECK(estimate->relative_error == alone->relative_error);
        CHECK(estimate->relative_error_trimmed == alone->relative_error_trimmed);
        CHECK(estimate->interval.upper == alone->interval.upper);
        CHECK(estimate->doubt == alone->doubt);
        for (std::size_t k = 0; k < gmis::ErrorEstimate::worst_count; ++k) {
          CHECK(estimate->worst[k].pixel == alone->worst[k].pixel);
          CHECK(estimate->worst[k].share == alone->worst[k].share);
        }
      }
    }
  }
}

TEST_CASE("a round grows with the run, within what may be lost and what may be held") {
  const gmis::PixelBounds small{{0, 0}, {64, 64}}, large{{0, 0}, {4096, 4096}};
  const gmis::RankRound<gmis::Vec3<float>> alone({}, small);
  CHECK(alone.length_after(1000, true) == 1);
  gmis_test::on_ranks(3, [&](const gmis::RanksRef& ranks) {
    if (!ranks.is_first()) return;
    const gmis::RankRound<gmis::Vec3<float>> round(ranks, small);
    CHECK(round.length_after(0, true) == 3);
    CHECK(round.length_after(24, true) == 6);  // a quarter
    CHECK(round.length_after(24, false) == 3);
    CHECK(round.length_after(192, false) == 6);  // a thirty-second part
    CHECK(round.length_after(1000, true) == 24);
    CHECK(gmis::RankRound<gmis::Vec3<float>>(ranks, large).length_after(1000, true) == 3);
  });
}
