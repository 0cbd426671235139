#include "gmis/render/render_run.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "gmis/render.hpp"
#include "gmis/render/join_runs.hpp"
#include "gmis/render/thread_executor.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/thread_ranks.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using Furnace = gmis_test::FurnaceScene<float>;
using Run = gmis::RenderRun<float>;
using Bytes = std::vector<std::byte>;

const Furnace furnace(0.7F, 1.0F, 9, 2);

gmis::RenderRequest request(std::uint32_t iterations, const gmis::SampleCounts& counts = gmis::integrators::bpt) {
  gmis::RenderRequest result;
  result.settings.max_depth = 4;
  result.settings.radius = 0.1;
  result.settings.seed = 3;
  result.settings.counts = counts;
  result.budget.iterations = iterations;
  result.intervals = true;
  return result;
}

/// Two counts, and the pilot that chooses between them.
gmis::RenderRequest with_pilot(std::uint32_t iterations) {
  gmis::RenderRequest result = request(iterations);
  result.candidates = {gmis::integrators::pt, gmis::integrators::bpt};
  result.expected_iterations = iterations;
  return result;
}

gmis::EngineMaker<float> engines() {
  return gmis::engines_with_pilot(furnace);
}
Run run_of(const gmis::RenderRequest& request) {
  return {engines(), furnace.camera().resolution(), request};
}

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

std::uint32_t iterations_in(const Bytes& checkpoint, const gmis::RenderRequest& request) {
  Run run = run_of(request);
  run.resume(checkpoint);
  return run.progress().iterations;
}

/// Sets a flag in the middle of its work, and stops by it.
class Stopping : public gmis::ThreadExecutor {
 public:
  Stopping(std::atomic<bool>& flag, int after) : gmis::ThreadExecutor(1), flag_(flag), left_(after) {}
  template <class Work>
  void parallel_for(std::size_t count, Work&& work) {
    if (--left_ == 0) flag_ = true;
    gmis::ThreadExecutor::parallel_for(count, work);
  }

 private:
  std::atomic<bool>& flag_;
  int left_;
};

}  // namespace

TEST_CASE("the last checkpoint has all iterations of the picture, after an interrupt too") {
  std::atomic<bool> interrupt{false};
  gmis::RenderRequest open_ended = request(1000, gmis::integrators::vcm);
  open_ended.interrupt = &interrupt;
  open_ended.seconds_between_pictures = 1e9;
  Bytes last;
  open_ended.on_checkpoint = [&](std::span<const std::byte> bytes) { last.assign(bytes.begin(), bytes.end()); };
  Stopping stopping(interrupt, 40);
  const gmis::RenderResult result = run_of(open_ended).run(stopping);
  CHECK(result.stopped_by == gmis::StopReason::interrupt);
  REQUIRE(result.iterations > 1);
  CHECK(iterations_in(last, open_ended) == result.iterations);

  // A run that has nothing left to do hands its state out, too.
  interrupt = false;
  open_ended.budget.iterations = result.iterations;
  Bytes again;
  open_ended.on_checkpoint = [&](std::span<const std::byte> bytes) { again.assign(bytes.begin(), bytes.end()); };
  Run finished = run_of(open_ended);
  finished.resume(last);
  gmis::SerialExecutor executor;
  CHECK(finished.run(executor).iterations == result.iterations);
  CHECK(iterations_in(again, open_ended) == result.iterations);
}

TEST_CASE("an executor is free of the run's interrupt when a callback has thrown") {
  std::atomic<bool> interrupt{false};
  gmis::RenderRequest thrown = request(10);
  thrown.interrupt = &interrupt;
  thrown.on_iteration = [](const gmis::RunState& state) {
    if (state.iterations == 2) throw std::runtime_error("enough");
  };
  gmis::ThreadExecutor executor(2);
  CHECK_THROWS_AS(run_of(thrown).run(executor), std::runtime_error);
  interrupt = true;
  CHECK_FALSE(executor.is_stopped());
}

TEST_CASE("a limit of the error ends the rendering of a few pixels") {
  for (const int side : {5, 7, 9}) {
    gmis::RenderRequest few = request(20'000, gmis::integrators::pt);
    few.budget.relative_error = 0.5;
    few.crop = gmis::PixelBounds{{0, 0}, {side, side}};
    gmis::SerialExecutor executor;
    const gmis::RenderResult result = run_of(few).run(executor);
    CAPTURE(side, result.iterations);
    CHECK(result.stopped_by == gmis::StopReason::error);
    CHECK(result.iterations < 100);
  }
}

TEST_CASE("a looser limit of the error ends a resumed run at its next estimate") {
  gmis::RenderRequest strict = request(1030, gmis::integrators::pt);
  strict.budget.relative_error = 1e-9;
  gmis::SerialExecutor executor;
  Run first = run_of(strict);
  (void)first.run(executor);
  gmis::RenderRequest loose = strict;
  loose.budget.iterations.reset();
  loose.budget.relative_error = 1.0;
  Run second = run_of(loose);
  second.resume(first.checkpoint());
  const gmis::RenderResult result = second.run(executor);
  CHECK(result.stopped_by == gmis::StopReason::error);
  CHECK(result.iterations <= 1031);
}

TEST_CASE("a request that no run can fulfil is refused, with what to change") {
  const auto refused = [](const auto& change) {
    gmis::RenderRequest wrong = request(2);
    change(wrong);
    return gmis_test::message_of([&] { run_of(wrong); });
  };
  using Request = gmis::RenderRequest;
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  CHECK(refused([](Request&) {}).empty());
  CHECK(contains(refused([&](Request& r) { r.budget.seconds = no_number; }), "Budget::seconds"));
  CHECK(refused([](Request& r) { r.budget.seconds = 0.0; }).empty());
  for (const double error : {no_number, -0.1, 0.0})
    CHECK(contains(refused([&](Request& r) { r.budget.relative_error = error; }), "Budget::relative_error"));
  for (const double share : {no_number, -1e-4})
    CHECK(contains(refused([&](Request& r) { r.rejection_limit.share = share; }), "RejectionLimit::share"));
  CHECK(refused([](Request& r) { r.rejection_limit.share = std::numeric_limits<double>::infinity(); }).empty());
  CHECK(contains(refused([](Request& r) { r.crop = gmis::PixelBounds{{4, 1}, {2, 3}}; }), "RenderRequest::crop"));
  CHECK(contains(refused([](Request& r) { r.class_pictures = true; }), "path_classes"));
}

TEST_CASE("what a chosen candidate could not render is refused before the pilot") {
  const auto refusal = [](auto change) {
    gmis::RenderRequest bad = with_pilot(8);
    change(bad);
    return gmis_test::message_of([&] { (void)run_of(bad); });
  };
  CHECK(contains(refusal([](auto& r) { r.settings.alpha = 2.0; }), "alpha"));
  CHECK(contains(refusal([](auto& r) { r.settings.alpha = -1.0; }), "alpha"));
  CHECK(contains(refusal([](auto& r) { r.candidates.back().connections = -1; }), "connections"));
  CHECK(contains(refusal([](auto& r) {
                   r.settings.counts = gmis::integrators::vcm;
                   r.candidates = {r.settings.counts, r.settings.counts};
                   r.candidates.back().radius_factor = 0.0;
                 }),
                 "radius_factor"));
}

TEST_CASE("a reference must have the size of the picture") {
  const std::vector<float> five(5, 1.0F);
  gmis::RenderRequest compared = request(8);
  compared.reference = five;
  CHECK(contains(gmis_test::message_of([&] { (void)run_of(compared); }), "reference"));
}

TEST_CASE("joined parts have the time and the forecast of all") {
  gmis::SerialExecutor executor;
  double cpu_seconds = 0.0;
  std::vector<Bytes> checkpoints;
  for (const auto& [first, last] : {std::pair{1U, 6U}, std::pair{7U, 12U}}) {
    gmis::RenderRequest request = with_pilot(12);
    request.part = gmis::RunPart{first, last, 12};
    Run part = run_of(request);
    cpu_seconds += part.run(executor).cpu_seconds;
    checkpoints.push_back(part.checkpoint());
  }
  const gmis::RenderResult joined =
      gmis::join_runs<float>(with_pilot(12), furnace.camera().resolution(), checkpoints, engines().properties);
  CHECK(joined.cpu_seconds == Approx(cpu_seconds).epsilon(0.05));
  CHECK(joined.forecast.has_value());
}

TEST_CASE("parts whose pilots have chosen other counts are not joined") {
  // The choice depends on the expected length, which is no part of a run's identity.
  gmis::SerialExecutor executor;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    std::vector<Bytes> checkpoints;
    std::vector<gmis::SampleCounts> chosen;
    gmis::RenderRequest whole = with_pilot(4);
    whole.settings.seed = seed;
    whole.candidates.push_back(gmis::integrators::bpt);
    whole.candidates.back().light_paths = 0.5;
    for (const auto& [first, expected] : {std::pair{1U, 2U}, std::pair{3U, 800U}}) {
      gmis::RenderRequest request = whole;
      request.part = gmis::RunPart{first, first + 1, 4};
      request.expected_iterations = expected;
      Run part = run_of(request);
      chosen.push_back(part.run(executor).counts);
      checkpoints.push_back(part.checkpoint());
    }
    if (chosen[0] == chosen[1]) continue;
    const std::string message = gmis_test::message_of([&] {
      return gmis::join_runs<float>(whole, furnace.camera().resolution(), checkpoints, engines().properties);
    });
    CHECK(contains(message, "other counts"));
    return;
  }
  FAIL("no seed of these makes two pilots differ");
}

TEST_CASE("several ranks render nothing where the crop has no rows") {
  gmis_test::on_ranks(2, [&](const gmis::RanksRef& ranks) {
    gmis::RenderRequest empty = request(2);
    empty.crop = gmis::PixelBounds{{0, 3}, {9, 3}};
    empty.ranks = ranks;
    gmis::SerialExecutor executor;
    CHECK(run_of(empty).run(executor).picture.values.empty());
  });
}

TEST_CASE("a checkpoint without an iteration is not called damaged") {
  Run run = run_of(request(4));
  const std::string message = gmis_test::message_of([&] {
    (void)gmis::join_runs<float>(request(4), furnace.camera().resolution(), std::vector<Bytes>{run.checkpoint()},
                                 engines().properties);
  });
  CHECK(contains(message, "no iteration"));
}
