#include "benchmark/selections.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "gmis/benchmark.hpp"
#include "gmis/mis.hpp"
#include "gmis/testing.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

const std::vector<test::Ramp> ramps{{-1.7}, {0.3}, {1.5}, {0.9}};
double f(double x) {
  return std::exp(2.0 * x);
}
gmis::TabulatedProblem problem_of(std::size_t n) {
  const std::array<double, 2> ends{0.0, 1.0};
  const std::vector<test::Ramp> some(ramps.begin(), ramps.begin() + static_cast<std::ptrdiff_t>(n));
  return {f, some, gmis::composite_gauss_legendre(ends, 3)};
}

}  // namespace

// The sum over all outcomes against the closed forms, which are derived otherwise.
TEST_CASE("S1, S2 and S3 written as your own selections have the variances of the six schemes", "[benchmark]") {
  for (const std::size_t n : {1U, 2U, 3U, 4U}) {
    const auto problem = problem_of(n);
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(n, name_of(weighting));
      const auto check = [&](gmis::Selection selection, const gmis::ExactMoments& moments) {
        CAPTURE(name_of(selection));
        const auto expected = gmis::exact_moments(gmis::scheme_of(selection, weighting), problem);
        CHECK(moments.mean == Approx(expected.mean).epsilon(1e-12));
        CHECK(moments.variance == Approx(expected.variance).epsilon(1e-9).margin(1e-13));
      };
      check(gmis::Selection::S1, gmis::exact_moments(test::WithReplacement{n}, weighting, problem));
      check(gmis::Selection::S2, gmis::exact_moments(test::WithoutReplacement{n}, weighting, problem));
      check(gmis::Selection::S3, gmis::exact_moments(test::InOrder{n}, weighting, problem));
    }
  }
}

TEST_CASE("marginal probabilities of a selection", "[benchmark]") {
  const auto marginals = gmis::marginal_probabilities(test::Sticky{}, 3);
  REQUIRE(marginals.size() == 6);
  CHECK(marginals[0] == Approx(0.5));
  CHECK(marginals[3] == Approx(0.4 * 0.5 + 0.6 * 0.5));
  CHECK(marginals[4] == Approx(0.3));
  struct Wrong {
    double p;
    std::size_t sample_count() const { return 1; }
    void next_probabilities(std::span<const std::uint32_t>, std::span<double> out) const {
      for (double& each : out) each = p;
    }
  };
  CHECK_THROWS_AS(gmis::marginal_probabilities(Wrong{0.6}, 2), std::invalid_argument);
  CHECK_THROWS_AS(gmis::marginal_probabilities(Wrong{-0.5}, 2), std::invalid_argument);
  CHECK_THROWS_AS(gmis::marginal_probabilities(test::WithReplacement{9}, 9, 1000), std::invalid_argument);
}

TEST_CASE("a selection of more samples than the sum can recurse into is refused", "[benchmark]") {
  struct Alternating {
    std::size_t samples;
    std::size_t sample_count() const { return samples; }
    void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
      out[0] = drawn.size() % 2 == 0 ? 1.0 : 0.0, out[1] = 1.0 - out[0];
    }
  };
  // Frames without optimisation under AddressSanitizer are five times as large: 2,000 of them fit.
  const Alternating many{2'000}, too_many{gmis::max_summed_samples + 1};
  const auto marginals = gmis::marginal_probabilities(many, 2);
  REQUIRE(marginals.size() == 2 * many.samples);
  CHECK(marginals[2 * many.samples - 1] == 1.0);
  CHECK_THROWS_AS(gmis::marginal_probabilities(too_many, 2), std::invalid_argument);
  const auto problem = problem_of(2);
  // One outcome: half of the samples are of each proposal, as in N3.
  const auto expected = gmis::exact_moments(gmis::Scheme::N3, problem);
  const auto moments = gmis::exact_moments(many, gmis::Weighting::W4, problem);
  CHECK(moments.mean == Approx(expected.mean).epsilon(1e-9));
  CHECK(moments.variance == Approx(expected.variance * 2.0 / static_cast<double>(many.samples)).epsilon(1e-6));
  for (const auto weighting : gmis::all_weightings) {
    CAPTURE(name_of(weighting));
    CHECK_THROWS_AS(gmis::exact_moments(too_many, weighting, problem), std::invalid_argument);
  }
  // Rounds that sum nothing take any number of samples.
  CHECK(gmis::SelectedRounds(too_many, gmis::Weighting::W1, 2).sample_count() == too_many.samples);
}

TEST_CASE("a selection whose probabilities are none is refused under every weighting", "[benchmark]") {
  struct Lacking {
    double first, second;
    std::size_t sample_count() const { return 2; }
    void next_probabilities(std::span<const std::uint32_t>, std::span<double> out) const {
      out[0] = first, out[1] = second;
    }
  };
  const auto problem = problem_of(2);
  for (const auto weighting : gmis::all_weightings) {
    CAPTURE(name_of(weighting));
    for (const Lacking& selection : {Lacking{0.5, 0.4}, {0.0, 0.0}, {1.5, -0.5}, {std::nan(""), 0.5}}) {
      CHECK_THROWS_AS(gmis::exact_moments(selection, weighting, problem), std::invalid_argument);
      CHECK_THROWS_AS(gmis::SelectedRounds(selection, weighting, 2), std::invalid_argument);
    }
    CHECK_NOTHROW(gmis::exact_moments(Lacking{0.5, 0.5}, weighting, problem));
  }
  // A later sample counts, too.
  struct Later {
    std::size_t sample_count() const { return 2; }
    void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
      out[0] = 0.5, out[1] = drawn.empty() ? 0.5 : 0.4;
    }
  };
  for (const auto weighting : gmis::all_weightings)
    CHECK_THROWS_AS(gmis::exact_moments(Later{}, weighting, problem), std::invalid_argument);
}

// Rounds that are drawn against the sum over all outcomes: 2 selections × 5 weightings, false-alarm
// rate 1e-4 in all.
TEST_CASE("rounds of your own selection have its exact moments", "[benchmark]") {
  const double level = test::sidak_level(1e-4, 10);
  const auto problem = problem_of(3);
  const std::vector<test::Ramp> three(ramps.begin(), ramps.begin() + 3);
  const auto set = gmis::as_proposal_set(three);
  std::uint32_t stream = 0;
  const auto check = [&](const auto& selection) {
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(name_of(weighting), stream);
      gmis::SelectedRounds rounds(selection, weighting, 3);
      gmis::Workspace<double, gmis::dynamic_capacity> workspace;
      gmis::Philox source(gmis_test::seed(91), stream++);
      const auto round = [&] {
        double sum = 0.0;
        const auto counts = rounds.sample(set, source, workspace, [&](double x, double phi, std::size_t) {
          sum += f(x) / phi / static_cast<double>(rounds.sample_count());
        });
        if (counts.density_evaluations == 0) FAIL("densities are not counted");
        return sum;
      };
      const auto result =
          gmis::check_estimator(round, gmis::exact_moments(selection, weighting, problem), 40000, level);
      INFO(result.text());
      CHECK(result.passes());
    }
  };
  check(test::Sticky{});
  check(test::Cyclic{3});
}
