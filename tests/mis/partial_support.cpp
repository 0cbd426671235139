#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Two proposals that cover [0, 1) only together: [0, 0.6) and [0.4, 1), f = 2x, ∫ f = 1. With A = ∫
// f over [0, 0.6) = 0.36 and B = ∫ f over [0.4, 1) = 0.84:
//   R1, N1  each draw sees its own proposal's part:                (A + B)/2             = 0.60
//   R2      both indices equal with probability 1/2, else ψ:       (A + B)/4 + 1/2       = 0.80
//   N2      the first draw is divided by ψ, the second by q_j:     1/2 + (A + B)/4       = 0.80
//   R3, N3  unbiased:                                               1

namespace {

using gmis::Scheme;

const std::array<test::Uniform, 2> halves{{{0.0, 0.6}, {0.4, 1.0}}};
double twice(double x) {
  return 2.0 * x;
}

double predicted_mean(Scheme scheme) {
  switch (scheme) {
    case Scheme::R1:
    case Scheme::N1:
      return 0.6;
    case Scheme::R2:
    case Scheme::N2:
      return 0.8;
    default:
      return 1.0;
  }
}

}  // namespace

TEST_CASE("the bias of partial support is the predicted one, for every pair", "[mis]") {
  const double level = test::sidak_level(1e-4, 45);
  std::uint64_t seed = 40;
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings)
      for (const std::uint64_t rounds : {1U, 2U, 3U}) {
        CAPTURE(name_of(selection), name_of(weighting), rounds);
        const Scheme scheme = scheme_of(selection, weighting);
        gmis::Philox source(gmis_test::seed(++seed));
        std::vector<double> means(6000 / rounds);
        for (double& mean : means) mean = gmis::estimate(selection, weighting, twice, halves, rounds, source).mean;
        const auto moments = test::moments_of(means);
        CAPTURE(moments.mean, moments.standard_error);
        CHECK(test::mean_p_value(moments, predicted_mean(scheme)) > level);
        if (needs_full_support(scheme)) CHECK(test::mean_p_value(moments, 1.0) < level);  // the bias is real
      }
}

TEST_CASE("exact_mean predicts the bias of partial support", "[mis]") {
  const std::array<double, 4> breakpoints{0.0, 0.4, 0.6, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(breakpoints, 1);
  const gmis::TabulatedProblem problem(twice, halves, nodes);
  CHECK_FALSE(problem.has_full_support());
  for (const Scheme scheme : gmis::all_schemes)
    CHECK(gmis::exact_mean(scheme, problem) == Approx(predicted_mean(scheme)).epsilon(1e-12));
  CHECK_THROWS_AS(gmis::exact_variance(Scheme::N2, problem), std::invalid_argument);
}

// With partial support the variance of R1 is no longer that of N1: in N1 the two parts are no
// longer noise.
TEST_CASE("exact variances hold with partial support", "[mis]") {
  const std::array<double, 4> breakpoints{0.0, 0.4, 0.6, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(breakpoints, 1);
  const gmis::TabulatedProblem problem(twice, halves, nodes);
  const double level = test::sidak_level(1e-3, 5);
  for (const Scheme scheme : {Scheme::R1, Scheme::R2, Scheme::R3, Scheme::N1, Scheme::N3}) {
    CAPTURE(name_of(scheme));
    gmis::Philox source(gmis_test::seed(90));
    std::vector<double> values(20000);
    for (double& value : values) value = gmis::estimate(scheme, twice, halves, 1, source).mean;
    CHECK(test::bootstrap_variance_interval(values, level, source).contains(gmis::exact_variance(scheme, problem)));
  }
  CHECK(gmis::exact_variance(Scheme::N1, problem) < 0.8 * gmis::exact_variance(Scheme::R1, problem));
}
