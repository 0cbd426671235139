#include "gmis/render/join_runs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/render.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/seed.hpp"
#include "transport/furnace_engines.hpp"
#include "transport/furnace_scene.hpp"

namespace {

using Furnace = gmis_test::FurnaceScene<float>;
using Render = gmis::Render<Furnace>;

const Furnace furnace(0.7F, 1.0F, 8, 2);
const glm::ivec2 resolution{8, 8};

/// Bidirectional path tracing with everything that may be kept; `seed`: the number of the run.
gmis::RenderRequest request(std::uint64_t seed, std::uint32_t iterations,
                            gmis::Sampler sampler = gmis::Sampler::independent) {
  gmis::RenderRequest result;
  result.settings.max_depth = 3;
  result.settings.counts = gmis::integrators::bpt;
  result.settings.seed = gmis_test::seed(seed);
  result.settings.sampler = sampler;
  result.settings.path_classes = gmis::PathClassSet::all();
  result.scene_name = "furnace";
  result.budget.iterations = iterations;
  result.intervals = result.halves = result.techniques = result.class_pictures = result.light_pictures = true;
  return result;
}

/// A run, its checkpoint and the frames of its iterations.
struct Run {
  std::vector<std::byte> checkpoint;
  gmis::RenderResult result;
  std::vector<std::vector<float>> frames;

  explicit Run(const gmis::RenderRequest& request) {
    gmis::SerialExecutor executor;
    Render render(furnace, request);
    for (std::uint32_t i = 0; i < *request.budget.iterations; ++i) {
      REQUIRE(render.advance(executor));
      frames.emplace_back(render.frame().begin(), render.frame().end());
    }
    checkpoint = render.checkpoint();
    render.finish_log();
    result = render.result(gmis::StopReason::iterations);
  }
};

gmis::RenderResult joined(const gmis::RenderRequest& request, const std::vector<std::vector<std::byte>>& checkpoints) {
  return gmis::join_runs<float>(request, resolution, checkpoints);
}

std::string refusal(const gmis::RenderRequest& request, const std::vector<std::vector<std::byte>>& checkpoints) {
  return gmis_test::message_of([&] { return joined(request, checkpoints); });
}

/// The rounding of a mean of floats to float, with one of each step before.
double rounding(double value) {
  return 4 * std::ldexp(1.0, -24) * std::abs(value);
}

}  // namespace

TEST_CASE("The picture of joined runs is the mean over the iterations of all") {
  const Run a(request(1, 9)), b(request(2, 5)), c(request(3, 2));
  // The request may be that of a run of its own: seed, limits and callbacks do not matter.
  const gmis::RenderResult all = joined(request(4, 77), {a.checkpoint, b.checkpoint, c.checkpoint});
  CHECK(all.stopped_by == gmis::StopReason::joined);
  CHECK(all.joined_seeds == std::vector<std::uint64_t>{gmis_test::seed(1), gmis_test::seed(2), gmis_test::seed(3)});
  CHECK(all.iterations == 16);
  const auto check_mean = [&](const std::vector<float>& picture, const std::vector<float>& first,
                              const std::vector<float>& second, const std::vector<float>& third, double n1, double n2,
                              double n3) {
    REQUIRE(picture.size() == first.size());
    for (std::size_t i = 0; i < picture.size(); ++i) {
      const double x = static_cast<double>(first[i]), y = static_cast<double>(second[i]);
      const double mean = (n1 * x + n2 * y + n3 * static_cast<double>(third[i])) / (n1 + n2 + n3);
      REQUIRE(std::abs(static_cast<double>(picture[i]) - mean) <= rounding(mean));
    }
  };
  check_mean(all.picture.values, a.result.picture.values, b.result.picture.values, c.result.picture.values, 9, 5, 2);
  check_mean(all.half_a.values, a.result.half_a.values, b.result.half_a.values, c.result.half_a.values, 5, 3, 1);
  check_mean(all.half_b.values, a.result.half_b.values, b.result.half_b.values, c.result.half_b.values, 4, 2, 1);
  REQUIRE(all.techniques.size() == a.result.techniques.size());
  for (std::size_t i = 0; i < all.techniques.size(); ++i) {
    CHECK(all.techniques[i].id.s == a.result.techniques[i].id.s);
    CHECK(all.techniques[i].id.t == a.result.techniques[i].id.t);
    check_mean(all.techniques[i].weighted.values, a.result.techniques[i].weighted.values,
               b.result.techniques[i].weighted.values, c.result.techniques[i].weighted.values, 9, 5, 2);
  }
  REQUIRE(all.by_light.size() == 1);
  check_mean(all.by_light[0].picture.values, a.result.by_light[0].picture.values, b.result.by_light[0].picture.values,
             c.result.by_light[0].picture.values, 9, 5, 2);
  REQUIRE(all.classes.classes.size() == a.result.classes.classes.size());
  for (std::size_t i = 0; i < all.classes.classes.size(); ++i) {
    check_mean(all.classes.classes[i].picture.values, a.result.classes.classes[i].picture.values,
               b.result.classes.classes[i].picture.values, c.result.classes.classes[i].picture.values, 9, 5, 2);
    CHECK(all.classes.classes[i].contributions == a.result.classes.classes[i].contributions +
                                                      b.result.classes.classes[i].contributions +
                                                      c.result.classes.classes[i].contributions);
  }
  CHECK(all.counters.rays == a.result.counters.rays + b.result.counters.rays + c.result.counters.rays);
  // Times are those that the checkpoints have, which one run alone tells.
  double cpu_seconds = 0, wall_seconds = 0;
  for (const Run* const run : {&a, &b, &c}) {
    const gmis::RenderResult alone = joined(request(4, 77), {run->checkpoint});
    cpu_seconds += alone.cpu_seconds;
    wall_seconds += alone.wall_seconds;
  }
  CHECK(all.cpu_seconds == cpu_seconds);
  CHECK(all.wall_seconds == wall_seconds);
  CHECK(wall_seconds > 0);
  CHECK(all.log.size() == 5);  // iterations 1, 4, 6 and 8 of the longest, and all
  CHECK(all.log.back().iteration == 16);
  REQUIRE(all.error.has_value());
  CHECK(all.log.back().estimated_error == all.error->relative_error);
  CHECK(all.prices.has_value());
  REQUIRE(all.merging_bias.has_value());
  CHECK(all.merging_bias->bound() == 0.0);  // nothing was merged
}

TEST_CASE("The variance of joined runs is that of all their iterations") {
  for (const gmis::Sampler sampler : {gmis::Sampler::independent, gmis::Sampler::sobol}) {
    const bool is_sobol = sampler == gmis::Sampler::sobol;
    const Run a(request(5, 19, sampler)), b(request(6, 17, sampler));
    const gmis::RenderResult all = joined(request(5, 1, sampler), {a.checkpoint, b.checkpoint});
    REQUIRE(all.variance.values.size() == 64);
    for (std::size_t i = 0; i < 64; ++i) {
      // Independent iterations: the sample variance of all of them. Replications: each of the 16,
      // of two or three iterations, is one part, and the weight of its squared deviation is w² / (1
      // − w).
      std::vector<long double> parts, counts;
      for (const Run* run : {&a, &b})
        for (std::size_t k = 0; k < run->frames.size(); ++k) {
          const std::size_t part = is_sobol ? (run == &a ? 0 : 8) + k % 8 : parts.size();
          if (part == parts.size()) parts.push_back(0), counts.push_back(0);
          parts[part] += static_cast<long double>(run->frames[k][i]);
          ++counts[part];
        }
      CHECK(parts.size() == (is_sobol ? 16 : 36));
      long double mean = 0, variance = 0;
      for (std::size_t p = 0; p < parts.size(); ++p) mean += parts[p] / 36;
      for (std::size_t p = 0; p < parts.size(); ++p) {
        const long double share = counts[p] / 36, deviation = parts[p] / counts[p] - mean;
        variance += share * share * deviation * deviation / (1 - share);
      }
      REQUIRE(static_cast<double>(all.variance.values[i]) == Approx(static_cast<double>(variance)).epsilon(1e-6));
    }
    double mean_variance = 0;
    for (const float value : all.variance.values) mean_variance += static_cast<double>(value) / 64;
    CHECK(all.estimate.variance == Approx(mean_variance).epsilon(1e-6));
  }
}

TEST_CASE("The error of two joined runs agrees with that of one run of all their iterations") {
  // The means over 30 seeds of the squared error that is stated, joined and of one run; and of the
  // true squared error of the joined pictures, since the furnace's value is known. Differences of
  // means follow Student's t with about 58 degrees of freedom; three comparisons share a
  // false-alarm rate of 1e-4 (Šidák), two-sided.
  constexpr int seeds = 30;
  struct Mean {
    std::vector<double> values;
    [[nodiscard]] double value() const {
      double sum = 0;
      for (const double x : values) sum += x / static_cast<double>(values.size());
      return sum;
    }
    [[nodiscard]] double squared_error() const {
      double sum = 0;
      for (const double x : values) sum += gmis::square(x - value());
      return sum / static_cast<double>(values.size() * (values.size() - 1));
    }
  };
  const double level = 1 - std::pow(1 - 1e-4, 1.0 / 3);
  const auto check_equal = [&](const Mean& x, const Mean& y) {
    const double limit =
        gmis::student_t_quantile(1 - level / 2, 2 * seeds - 2) * std::sqrt(x.squared_error() + y.squared_error());
    CAPTURE(x.value(), y.value(), limit);
    CHECK(std::abs(x.value() - y.value()) < limit);
    CHECK(limit < 0.25 * y.value());  // it could tell the error of one of the two runs from that of both
  };
  const double truth = 1 + 0.7 + 0.7 * 0.7;
  std::uint64_t seed = 100;
  for (const gmis::Sampler sampler : {gmis::Sampler::independent, gmis::Sampler::sobol}) {
    Mean stated, one_run, true_error;
    for (int i = 0; i < seeds; ++i) {
      const std::uint64_t first = ++seed, second = ++seed, third = ++seed;
      auto of = [&](std::uint64_t number, std::uint32_t iterations) {
        gmis::RenderRequest plain = request(number, iterations, sampler);
        plain.halves = plain.techniques = plain.class_pictures = plain.light_pictures = false;
        plain.settings.path_classes.reset();
        return plain;
      };
      const Run a(of(first, 24)), b(of(second, 40)), whole(of(third, 64));
      const gmis::RenderResult both = joined(of(first, 1), {a.checkpoint, b.checkpoint});
      REQUIRE(both.error.has_value());
      stated.values.push_back(gmis::square(both.error->relative_error));
      one_run.values.push_back(gmis::square(whole.result.error->relative_error));
      double error = 0;
      for (const float value : both.picture.values)
        error += gmis::square(static_cast<double>(value) - truth) / (truth * truth + gmis::relative_error_floor) / 64;
      true_error.values.push_back(error);
    }
    // The error of a Sobol' run falls faster than that of the mean of its replications: one run of
    // all iterations is better.
    if (sampler == gmis::Sampler::independent) check_equal(stated, one_run);
    check_equal(stated, true_error);
  }
}

TEST_CASE("Runs with a pilot each: times, choice and bias of both") {
  gmis::SerialExecutor executor;
  const auto automatic = [](std::uint64_t seed, std::uint32_t iterations) {
    gmis::RenderSettings settings;
    settings.max_depth = 4;
    settings.radius = 0.05;
    settings.seed = gmis_test::seed(seed);
    gmis::RenderRequest result = gmis::automatic_request(furnace, {.iterations = iterations}, 1, settings);
    result.scene_name = "furnace";
    return result;
  };
  std::vector<std::vector<std::byte>> checkpoints;
  std::vector<gmis::RenderResult> results;
  for (const auto& one : {automatic(11, 12), automatic(12, 30)}) {
    Render render(furnace, one);
    results.push_back(render.run(executor));
    checkpoints.push_back(render.checkpoint());
  }
  const gmis::RenderResult all = joined(automatic(11, 5), checkpoints);
  REQUIRE(all.choice.has_value());
  CHECK(all.choice->chosen == results[1].choice->chosen);  // of the longer run
  CHECK(all.counts == results[1].counts);
  CHECK(all.choice->pilot_iterations == results[0].choice->pilot_iterations + results[1].choice->pilot_iterations);
  CHECK(all.choice->pilot_cost == Approx(results[0].choice->pilot_cost + results[1].choice->pilot_cost));
  REQUIRE(all.merging_bias.has_value());
  for (const gmis::RenderResult& one : results) REQUIRE(one.merging_bias.has_value());
  CHECK(all.merging_bias->bound() > 0);
  for (const gmis::RenderResult& one : results)
    CHECK(all.merging_bias->bound() != Approx(one.merging_bias->bound()).epsilon(1e-3));  // it is of both
  CHECK(all.forecast.has_value());
  // The order does not matter for the picture but for rounding.
  std::reverse(checkpoints.begin(), checkpoints.end());
  const gmis::RenderResult reversed = joined(automatic(11, 5), checkpoints);
  for (std::size_t i = 0; i < 64; ++i)
    CHECK(std::abs(static_cast<double>(all.picture.values[i] - reversed.picture.values[i])) <=
          rounding(static_cast<double>(all.picture.values[i])));
  CHECK(reversed.merging_bias->bound() == Approx(all.merging_bias->bound()).epsilon(1e-3));
}

TEST_CASE("Runs that cannot be joined are refused, and the message names what differs") {
  const Run a(request(1, 3)), b(request(2, 3)), again(request(1, 5));
  const gmis::RenderRequest same = request(1, 3);
  CHECK(refusal(same, {a.checkpoint, b.checkpoint}).empty());
  CHECK(refusal(same, {a.checkpoint, b.checkpoint, again.checkpoint}) ==
        "checkpoints 1 and 3 are of runs with the same seed, " + std::to_string(gmis_test::seed(1)) +
            ": the same samples twice");
  const auto refused = [&](const gmis::RenderRequest& other, const std::string& part) {
    const Run differs(other);
    const std::string message = refusal(same, {a.checkpoint, differs.checkpoint});
    INFO(message);
    CHECK(message.find("checkpoint 2: the checkpoint is of another run: " + part) != std::string::npos);
  };
  gmis::RenderRequest other = request(2, 3);
  other.scene_name = "kiln";
  refused(other, "the scene differs: kiln, not furnace");
  other = request(2, 3);
  other.scene_properties = {{"the content of bricks.png", "1234"}};
  refused(other, "the content of bricks.png is in the place of the instruction set");
  other = request(2, 3);
  other.settings.max_depth = 4;
  refused(other, "the greatest depth differs: 4, not 3");
  other = request(2, 3);
  other.settings.counts.connections = 2;
  refused(other, "the number of samples of the techniques differs");
  other = request(2, 3);
  other.crop = gmis::PixelBounds{{0, 0}, {4, 8}};
  refused(other, "the crop differs: 0,0,4,8, not 0,0,8,8");
  other = request(2, 3);
  other.halves = false;
  refused(other, "what is kept differs");
  other = request(2, 3, gmis::Sampler::sobol);
  refused(other, "the sampler differs");

  CHECK(refusal(same, {}).find("at least one") != std::string::npos);
  std::vector<std::byte> damaged = b.checkpoint;
  damaged[damaged.size() / 2] ^= std::byte{1};
  CHECK(refusal(same, {a.checkpoint, damaged}) == "checkpoint 2: the checkpoint is damaged: its digest differs");
  std::vector<std::byte> shorter = b.checkpoint;
  shorter.resize(shorter.size() - 1);
  CHECK(refusal(same, {shorter, a.checkpoint}) == "checkpoint 1: the checkpoint is cut short or longer than it says");
  std::vector<std::byte> older = b.checkpoint;
  const std::string name = "gmis checkpoint ";
  const auto at = std::search(older.begin(), older.end(), name.begin(), name.end(),
                              [](std::byte byte, char c) { return byte == static_cast<std::byte>(c); });
  REQUIRE(at != older.end());
  *(at + static_cast<std::ptrdiff_t>(name.size())) = std::byte{'1'};
  CHECK(refusal(same, {a.checkpoint, older}) == "checkpoint 2: this is no checkpoint of this version");
}

TEST_CASE("A reference of another size than the runs is refused") {
  const Run a(request(1, 3)), b(request(2, 3));
  std::vector<float> reference(64, 1.0F);
  gmis::RenderRequest compared = request(1, 3);
  compared.reference = reference;
  CHECK(joined(compared, {a.checkpoint, b.checkpoint}).log.back().reference_error.has_value());
  for (const std::size_t size : {1U, 63U, 65U}) {
    reference.resize(size);
    compared.reference = reference;
    CHECK(refusal(compared, {a.checkpoint, b.checkpoint}) ==
          "RenderRequest::reference must have the pixels and channels of the crop");
  }
}

/// The bytes of a checkpoint whose body was changed, with its digest anew.
std::vector<std::byte> with_new_digest(const std::vector<std::byte>& checkpoint) {
  std::string format;
  std::uint64_t digest = 0, size = 0;
  gmis::StateReader start(checkpoint);
  start(format, digest, size);
  const auto body = start.left();
  digest = gmis::digest_of(body);
  gmis::StateWriter anew;
  anew(format, digest, size);
  std::vector<std::byte> result = anew.bytes();
  result.insert(result.end(), body.begin(), body.end());
  return result;
}

TEST_CASE("The instruction set is refused where the bits would differ, and not where only samples must") {
  const Run a(request(1, 3)), b(request(2, 3));
  std::vector<std::byte> elsewhere = a.checkpoint;
  const std::string level(gmis::instruction_set);
  const auto at = std::search(elsewhere.begin(), elsewhere.end(), level.begin(), level.end(),
                              [](std::byte byte, char c) { return byte == static_cast<std::byte>(c); });
  REQUIRE(at != elsewhere.end());
  *at = std::byte{'y'};
  elsewhere = with_new_digest(elsewhere);
  Render render(furnace, request(1, 3));
  const std::string differing = "y" + level.substr(1);
  try {
    render.resume(elsewhere);
    FAIL("resumed on another instruction set");
  } catch (const std::invalid_argument& error) {
    CHECK(error.what() ==
          "the checkpoint is of another run: the instruction set differs: " + differing + ", not " + level);
  }
  const gmis::RenderResult all = joined(request(1, 3), {elsewhere, b.checkpoint});
  CHECK(all.iterations == 6);
  CHECK(all.picture.values == joined(request(1, 3), {a.checkpoint, b.checkpoint}).picture.values);
}

TEST_CASE("A file that the scene refers to is part of the run's identity") {
  gmis::RenderRequest with_file = request(1, 2);
  with_file.scene_properties = {{"the content of bricks.png", "1234"}};
  const Run run(with_file);
  const auto refused_by = [&](std::vector<std::pair<std::string, std::string>> properties) {
    gmis::RenderRequest other = request(1, 2);
    other.scene_properties = std::move(properties);
    Render render(furnace, other);
    return gmis_test::message_of([&] { render.resume(run.checkpoint); });
  };
  CHECK(refused_by({{"the content of bricks.png", "1234"}}).empty());
  CHECK(refused_by({{"the content of bricks.png", "1235"}}) ==
        "the checkpoint is of another run: the content of bricks.png differs: 1234, not 1235");
  CHECK(refused_by({{"the content of stone.png", "1234"}})
            .find("the content of bricks.png is in the place of the content of stone.png") != std::string::npos);
}
