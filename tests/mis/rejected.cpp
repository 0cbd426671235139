#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};

}  // namespace

TEST_CASE("a non-finite integrand is counted and never summed", "[mis]") {
  const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity());
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(1)), same_source(gmis_test::seed(1));
      const auto with_bad = gmis::estimate(
          selection, weighting, [&](double x) { return x < 0.1 ? bad : x; }, ramps, 500, source);
      std::uint64_t below = 0;
      const auto with_zero = gmis::estimate(
          selection, weighting, [&](double x) { return x < 0.1 ? (++below, 0.0) : x; }, ramps, 500, same_source);
      CHECK(with_bad.mean == with_zero.mean);
      CHECK(with_bad.variance == with_zero.variance);
      CHECK(with_bad.integrand_evaluations == 1000);
      CHECK(below > 0);
      CHECK(with_bad.rejected == gmis::Rejected{below, 0, 0, 0});
    }
}

TEST_CASE("one non-finite channel rejects the sample", "[mis]") {
  gmis::Philox source(gmis_test::seed(1));
  const auto estimate = gmis::estimate<gmis::Scheme::N3>(
      [](double x) { return glm::vec3(1.0F, x < 0.5 ? std::nanf("") : 1.0F, 2.0F); }, ramps, 2000, source);
  CHECK(estimate.rejected.non_finite_integrand > 0);
  CHECK(estimate.mean.x == Approx(estimate.mean.y).epsilon(1e-12));  // the sample is missing from all channels alike
  CHECK(estimate.mean.z == Approx(2.0 * estimate.mean.x).epsilon(1e-12));
}

TEST_CASE("a proposal that gives its own sample no usable density is counted by cause", "[mis]") {
  struct Case {
    double fault;
    bool is_zero;
  };
  const auto [fault, is_zero] = GENERATE(Case{0.0, true}, Case{std::numeric_limits<double>::quiet_NaN(), false},
                                         Case{std::numeric_limits<double>::infinity(), false}, Case{-1.0, false});
  const std::array<test::FaultyDensity, 3> proposals{{{fault}, {fault}, {fault}}};
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(fault, name_of(selection), name_of(weighting));
      gmis::Philox source(gmis_test::seed(4));
      const auto estimate = gmis::estimate(
          selection, weighting, [](double) { return 1.0; }, proposals, 1000, source);
      const std::uint64_t counted = is_zero ? estimate.rejected.zero_density : estimate.rejected.non_finite_density;
      CHECK(estimate.rejected.total() == counted);
      CHECK(estimate.integrand_evaluations == 3000 - counted);
      // Half of 3000 samples: 1500 ± 27.4; five standard deviations are a false alarm in 6e-7 of
      // seeds, 60 tests.
      CHECK(std::abs(static_cast<double>(counted) - 1500.0) < 5.0 * 27.4);
      CHECK(estimate.mean == Approx(static_cast<double>(3000 - counted) / 3000.0).epsilon(1e-12));
    }
}

// Only the sampling proposal's own density betrays this error: the mixture is positive.
TEST_CASE("a zero density of a drawn sample is seen behind a positive mixture", "[mis]") {
  struct Either {
    double fault;
    double sample(gmis::Philox& source) const { return gmis::uniform<double>(source); }
    double pdf(double x) const { return x > 0.5 ? fault : 1.0; }
  };
  const std::array<Either, 2> proposals{{{0.0}, {1.0}}};
  gmis::Philox source(gmis_test::seed(4));
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](double) { return 1.0; }, proposals, 1000, source);
  CHECK(estimate.rejected.zero_density > 400);
  CHECK(estimate.rejected.zero_density < 600);
}

TEST_CASE("a ratio that leaves the range of double is counted by its own cause", "[mis]") {
  struct Thin {
    double sample(gmis::Philox& source) const { return 1e300 * gmis::uniform<double>(source); }
    double pdf(double) const { return 1e-300; }
  };
  const std::array<Thin, 1> proposals{};
  gmis::Philox source(gmis_test::seed(4));
  const auto estimate = gmis::estimate<gmis::Scheme::R1>([](double) { return 1e100; }, proposals, 10, source);
  CHECK(estimate.rejected == gmis::Rejected{0, 0, 0, 10});
  CHECK(estimate.mean == 0.0);
}

TEST_CASE("a failed sample is counted apart from errors", "[mis]") {
  struct Never {
    std::optional<double> sample(gmis::Philox&) const { return std::nullopt; }
    double pdf(double) const { return 0.0; }
  };
  const auto proposals = std::make_tuple(Never{}, test::Uniform{});
  for (const auto selection : {gmis::Selection::S2, gmis::Selection::S3})
    for (const auto weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(4));
      const auto estimate = gmis::estimate(
          selection, weighting, [](double x) { return x; }, proposals, 100, source);
      CHECK(estimate.failed_samples == 100);
      CHECK(estimate.rejected.total() == 0);
      CHECK(estimate.samples == 200);
      CHECK(estimate.integrand_evaluations == 100);
    }
}
