#include "gmis/result/sobol_gain.hpp"

#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <numeric>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/render/run_record.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/error_law.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

constexpr int side = 40;
constexpr std::uint32_t replications = gmis::sobol_replications;

/// A picture whose pixels are 1, or 2 in every other, + `even` (u − ½) + (v − ½), u a coordinate of
/// Sobol' points, v an independent number; and, in one pixel, now and then a very bright sample.
struct Run {
  gmis::Film<float> film{glm::ivec2(side)};
  gmis::BatchMeans<float> means{glm::ivec2(side), replications};

  Run(std::uint64_t seed, int iterations, double even, bool has_firefly = false) {
    std::vector<float> frame(side * side);
    for (int i = 0; i < iterations; ++i) {
      const auto n = static_cast<std::uint32_t>(i);
      for (std::uint32_t p = 0; p < frame.size(); ++p) {
        auto points = gmis::SampleNumbers::sobol(seed, n % replications, p, 1, n / replications, 12);
        gmis::Philox independent(seed, n, p);
        frame[p] = static_cast<float>(1 + p % 2) + static_cast<float>(even * (gmis::uniform<double>(points) - 0.5)) +
                   gmis::uniform<float>(independent) - 0.5F;
      }
      if (has_firefly && i == 3) frame[7] += 1000.0F;
      film.add_iteration(frame);
      means.add_iteration(frame);
    }
  }
};

}  // namespace

TEST_CASE("the evenness of a run is what its replications take away, by the closed form") {
  // The variance of a scrambled mean of n = N / 8 points of u is 1 / (12 n³) for n a power of two:
  // of one value in each n-th part. So (1 + even² / n²) / (1 + even²) remains.
  for (const int iterations : {16, 64, 256})
    for (const double even : {0.0, 0.5, 1.0, 2.0}) {
      const double n = iterations / 8.0, remains = (1 + even * even / (n * n)) / (1 + even * even);
      const double expected = (1 - remains) / (1 - std::sqrt(8.0 / iterations));
      const Run run(gmis_test::seed(61), iterations, even);
      const auto measured = gmis::measured_evenness(run.film, gmis::variances_of_means(run.means));
      REQUIRE(measured.has_value());
      CAPTURE(iterations, even, remains, *measured);
      // 1600 pixels with seven degrees of freedom: the ratio has a standard error of √(2 / 11200),
      // and the one from iterations less.
      const double error = std::sqrt(2.0 / (7 * side * side) + 2.0 / ((iterations - 1.0) * side * side));
      CHECK(std::abs(std::min(expected, 0.95) - *measured) <= 6 * error / (1 - std::sqrt(8.0 / iterations)));
      // The law with it has the error that the replications tell.
      const std::vector<double> variances = gmis::variances_of_means(run.means);
      const double variance =
          std::accumulate(variances.begin(), variances.end(), 0.0) / static_cast<double>(variances.size());
      const gmis::ErrorLaw law{(1 + even * even) / 12, 0.0, 1.0, *measured};
      if (expected < 0.9 && *measured > 0)
        CHECK(std::pow(law.error_at(iterations), 2) == Approx(variance).epsilon(0.1));
    }
}

TEST_CASE("a few bright samples do not hide the evenness, and a short run has none") {
  const Run plain(gmis_test::seed(62), 64, 1.0), firefly(gmis_test::seed(62), 64, 1.0, true);
  const auto evenness_of = [](const Run& run) {
    return gmis::measured_evenness(run.film, gmis::variances_of_means(run.means));
  };
  CHECK(*evenness_of(firefly) == Approx(*evenness_of(plain)).margin(0.01));
  const Run brief(gmis_test::seed(62), 15, 1.0);
  CHECK_FALSE(evenness_of(brief).has_value());
}

TEST_CASE("runs that are joined show no evenness: their parts are not replications") {
  gmis::RenderRequest request;
  request.intervals = true;
  request.settings.sampler = gmis::Sampler::sobol;
  const auto record_of = [&](const Run& run) {
    gmis::RunRecord<float> record(request, glm::ivec2(side));
    record.film = run.film;
    record.batches = run.means;
    record.expected_law.evenness = 0.5;
    return record;
  };
  gmis::RunRecord<float> record = record_of(Run(gmis_test::seed(63), 64, 1.0));
  CHECK(record.law_so_far(record.variances(request)).evenness > 0.55);
  record.join(record_of(Run(gmis_test::seed(64), 64, 1.0)));
  CHECK(record.variances(request).size() == side * side);
  CHECK(record.law_so_far(record.variances(request)).evenness == 0.5);
}
