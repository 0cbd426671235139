#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Scheme;

std::vector<std::uint32_t> apportioned(std::vector<double> weights, std::size_t total) {
  std::vector<std::uint32_t> counts(weights.size());
  gmis::apportion<double>(weights, total, counts);
  return counts;
}

}  // namespace

TEST_CASE("samples are apportioned by largest remainders", "[mis]") {
  using Counts = std::vector<std::uint32_t>;
  CHECK(apportioned({0.5, 0.3, 0.2}, 10) == Counts{5, 3, 2});
  CHECK(apportioned({0.5, 0.3, 0.2}, 4) == Counts{2, 1, 1});
  CHECK(apportioned({5.0, 3.0, 2.0}, 1) == Counts{1, 0, 0});
  CHECK(apportioned({1.0, 1.0, 1.0}, 2) == Counts{1, 1, 0});  // ties go to the lower index
  CHECK(apportioned({0.0, 1.0}, 3) == Counts{0, 3});
  CHECK_THROWS_AS(apportioned({0.0, 0.0}, 3), std::invalid_argument);
  gmis::Philox source(gmis_test::seed(1));
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> weights(1 + gmis::uniform_index(source, 9));
    double sum = 0.0;
    for (double& weight : weights) sum += weight = gmis::uniform<double>(source);
    const std::size_t total = gmis::uniform_index(source, 40);
    std::size_t given = 0;
    const auto counts = apportioned(weights, total);
    for (std::size_t k = 0; k < counts.size(); ++k) {
      given += counts[k];
      CHECK(std::abs(counts[k] - weights[k] / sum * static_cast<double>(total)) < 1.0);
    }
    CHECK(given == total);
  }
}

// 15 pairs × 2 allocations and 5 × 1; false-alarm rate 1e-4 for the family.
TEST_CASE("an unequal allocation leaves every pair unbiased", "[mis]") {
  const std::array<test::Ramp, 3> ramps{{{-1.4}, {0.3}, {1.4}}};
  const auto f = [](double x) { return 3.0 * x * x; };
  const double level = test::sidak_level(1e-4, 35);
  const std::array<double, 3> weights{0.6, 0.3, 0.1};
  const std::array<gmis::SampleAllocation<double, 8>, 3> allocations{
      gmis::SampleAllocation<double, 8>(std::span<const double>(weights), 5),
      gmis::SampleAllocation<double, 8>(std::span<const double>(weights), 1),
      gmis::SampleAllocation<double, 8>(std::array<std::uint32_t, 3>{0, 2, 1})};
  for (const auto& allocation : allocations)
    for (const auto selection : gmis::all_selections)
      for (const auto weighting : gmis::all_weightings) {
        // One sample for three proposals of positive weight: a random selection alone can use it.
        if (allocation.sample_count(3) == 1 && selection != gmis::Selection::S1) continue;
        CAPTURE(name_of(selection), name_of(weighting), allocation.sample_count(3));
        gmis::Philox source(gmis_test::seed(14));
        const auto estimate = gmis::estimate(selection, weighting, f, ramps, 6000, source, allocation);
        CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > level);
        CHECK(estimate.samples == 6000 * allocation.sample_count(3));
      }
}

TEST_CASE("counts of one each, equal weights, are the equal allocation", "[mis]") {
  const std::array<test::Ramp, 3> ramps{{{-1.4}, {0.3}, {1.4}}};
  const auto f = [](double x) { return std::exp(x); };
  const gmis::SampleAllocation<double> ones(std::array<std::uint32_t, 3>{1, 1, 1});
  for (const auto selection : {gmis::Selection::S2, gmis::Selection::S3})
    for (const auto weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(14)), same_source(gmis_test::seed(14));
      const auto a = gmis::estimate(selection, weighting, f, ramps, 100, source, ones);
      const auto b = gmis::estimate(selection, weighting, f, ramps, 100, same_source);
      CHECK(a.mean == Approx(b.mean).epsilon(1e-14));
      CHECK(a.density_evaluations == b.density_evaluations);
    }
}

TEST_CASE("S1 draws proposal k with its weight, S2 and S3 give it its count", "[mis]") {
  const std::array<test::Ramp, 4> ramps{};
  const std::array<double, 4> weights{0.5, 0.0, 0.3, 0.2};
  const gmis::SampleAllocation<double> allocation(std::span<const double>(weights), 10);
  const auto set = gmis::as_proposal_set(ramps);
  gmis::Workspace<double, 10> workspace;
  gmis::Philox source(gmis_test::seed(2));
  std::array<double, 4> drawn{};
  for (int round = 0; round < 2000; ++round)
    gmis::sample_round<Scheme::R3>(set, allocation, source, workspace,
                                   [&](double, double, std::size_t k) { drawn[k] += 1.0; });
  CHECK(drawn[1] == 0.0);
  double chi_squared = 0.0;
  for (const std::size_t k : {std::size_t{0}, std::size_t{2}, std::size_t{3}}) {
    const double expected = 20000.0 * weights[k];
    chi_squared += (drawn[k] - expected) * (drawn[k] - expected) / expected;
  }
  CHECK(std::exp(-0.5 * chi_squared) > 1e-4);  // the tail of χ² with two degrees of freedom

  for (const auto selection : {gmis::Selection::S2, gmis::Selection::S3}) {
    std::array<std::uint32_t, 4> counts{};
    gmis::dispatch(selection, gmis::Weighting::W1, [&](auto s, auto w) {
      return gmis::sample_round<decltype(s)::value, decltype(w)::value>(
          set, allocation, source, workspace, [&](double, double, std::size_t k) { ++counts[k]; });
    });
    CHECK(counts == std::array<std::uint32_t, 4>{5, 0, 3, 2});
  }
}

// The mixture that a sample is divided by, spelled out.
TEST_CASE("the mixtures of an unequal allocation", "[mis]") {
  const std::array<test::Ramp, 3> ramps{{{-1.4}, {0.3}, {1.4}}};
  const std::array<double, 3> weights{0.55, 0.3, 0.15};
  const gmis::SampleAllocation<double, 8> allocation(std::span<const double>(weights),
                                                     4);  // counts 2, 1, 1 (quotas 2.2, 1.2, 0.6)
  REQUIRE(allocation.count(0) == 2);
  REQUIRE(allocation.count(1) == 1);
  REQUIRE(allocation.count(2) == 1);
  const auto set = gmis::as_proposal_set(ramps);
  gmis::Workspace<double, 8> workspace;
  gmis::Philox source(gmis_test::seed(2));
  gmis::sample_round<Scheme::R3>(set, allocation, source, workspace, [&](double x, double phi, std::size_t) {
    CHECK(phi == Approx(0.55 * ramps[0].pdf(x) + 0.3 * ramps[1].pdf(x) + 0.15 * ramps[2].pdf(x)));
  });
  gmis::sample_round<Scheme::N3>(set, allocation, source, workspace, [&](double x, double phi, std::size_t) {
    CHECK(phi == Approx((2.0 * ramps[0].pdf(x) + ramps[1].pdf(x) + ramps[2].pdf(x)) / 4.0));
  });
  std::array<double, 3> left{2.0, 1.0, 1.0};
  double total = 4.0;
  gmis::sample_round<Scheme::N2>(set, allocation, source, workspace, [&](double x, double phi, std::size_t k) {
    CHECK(phi == Approx((left[0] * ramps[0].pdf(x) + left[1] * ramps[1].pdf(x) + left[2] * ramps[2].pdf(x)) / total));
    left[k] -= 1.0;
    total -= 1.0;
  });
}

// What is left is summed afresh: next to a density of 1e17, a remainder made by subtraction would
// be rounding noise.
TEST_CASE("N2 loses nothing next to a huge density", "[mis]") {
  struct Constant {
    double density;
    double sample(gmis::Philox& source) const { return gmis::uniform<double>(source); }
    double pdf(double) const { return density; }
  };
  const std::array<Constant, 3> proposals{{{1e17}, {1.0}, {2.0}}};
  gmis::Philox source(gmis_test::seed(6));
  for (int round = 0; round < 50; ++round) {
    std::array<bool, 3> drawn{};
    gmis::sample_round<Scheme::N2>(proposals, source, [&](double, double phi, std::size_t k) {
      double sum = 0.0, count = 0.0;
      for (std::size_t m = 0; m < 3; ++m)
        if (!drawn[m]) {
          sum += proposals[m].density;
          count += 1.0;
        }
      CHECK(phi == Approx(sum / count).epsilon(1e-15));
      drawn[k] = true;
    });
  }
}
