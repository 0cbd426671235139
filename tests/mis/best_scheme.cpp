#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::CostModel;
using gmis::Scheme;

/// Eight proposals that tile [0, 1), each with `share` of its density spread over all of it; f is
/// the mixture with `f_share` spread and a slope. With shares equal to one every proposal resembles
/// f; with small ones only the mixture does.
struct Problem {
  std::vector<test::Bump> bumps;
  std::vector<gmis::QuadratureNode> nodes;
  explicit Problem(double share) {
    std::vector<double> breakpoints{0.0};
    for (int k = 0; k < 8; ++k) {
      bumps.push_back({k / 8.0, (k + 1) / 8.0, share});
      breakpoints.push_back((k + 1) / 8.0);
    }
    nodes = gmis::composite_gauss_legendre(breakpoints, 1);
  }
  static double f(double x) { return 1.0 + 0.5 * std::sin(9.0 * x); }
};

/// The least variance × cost, from exact_variance, exact_moments and the counts written down here
/// again: R2's distinct indices by their expectation, N2's triangle, P N for groups.
struct Exact {
  double score;
  double variance;
};
std::vector<Exact> exact_scores(const Problem& problem, CostModel costs) {
  const gmis::TabulatedProblem table(Problem::f, problem.bumps, problem.nodes);
  const auto cost = [&](double evaluations) { return evaluations * costs.per_density + 8.0 * costs.per_sample; };
  std::vector<Exact> scores;
  const double distinct = 8.0 * (1.0 - std::pow(7.0 / 8.0, 8.0));
  for (const Scheme scheme : gmis::all_schemes) {
    const double variance = exact_variance(scheme, table);
    const double evaluations = scheme == Scheme::R1 || scheme == Scheme::N1 ? 8.0
                               : scheme == Scheme::R2                       ? 8.0 * distinct
                               : scheme == Scheme::N2                       ? 36.0
                                                                            : 64.0;
    scores.push_back({variance * cost(evaluations), variance});
  }
  for (const std::size_t size : {2U, 3U, 4U}) {  // groups of 6 of 8 are groups of 4
    const gmis::Groups<> groups(8, size);
    double squares = 0.0;
    for (std::size_t g = 0; g < groups.size(); ++g)
      squares += static_cast<double>(groups.members(g).size() * groups.members(g).size());
    const double variance = exact_moments(groups, table).variance;
    scores.push_back({variance * cost(squares), variance});
  }
  return scores;
}

/// Densities about e^-2000.
struct Far {
  double mean;
  double sample(gmis::UniformSource auto& source) const { return test::Normal{mean, 1.0}.sample(source); }
  double log_pdf(double x) const { return std::log(test::Normal{mean, 1.0}.pdf(x)) - 2000.0; }
};

}  // namespace

// Low, medium and high mismatch × densities that are cheap, level and dear: nine problems whose
// best answers differ.
TEST_CASE("best_scheme picks what exact variances and costs say", "[mis]") {
  const double share = GENERATE(1.0, 0.6, 0.02);
  const Problem problem(share);
  gmis::Philox source(gmis_test::seed(11));
  const gmis::PilotSamples pilot(Problem::f, problem.bumps, 500, source);
  for (const CostModel costs : {CostModel{1.0, 1000.0}, CostModel{10.0, 10.0}, CostModel{1000.0, 1.0}}) {
    CAPTURE(share, costs.per_density, costs.per_sample);
    const auto exact = exact_scores(problem, costs);
    // As many draws of the indices as leave R2 and N2 the error of the pilot alone.
    const auto choice = gmis::best_scheme(pilot.problem(), costs, source, 1000);
    REQUIRE(choice.candidates.size() == exact.size());
    double least = exact[0].score;
    for (const Exact& candidate : exact) least = std::min(least, candidate.score);
    // The pilot estimates: its choice may be a neighbour of the best, never one that costs a tenth
    // more.
    CHECK(exact[choice.best].score <= 1.1 * least);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CAPTURE(i, choice.candidates[i].variance, exact[i].variance);
      CHECK(choice.candidates[i].is_unbiased);
      CHECK(choice.candidates[i].variance == Approx(exact[i].variance).epsilon(0.25).margin(1e-15));
    }
    // And with the quadrature nodes in place of a pilot it is the best itself.
    const gmis::TabulatedProblem table(Problem::f, problem.bumps, problem.nodes);
    CHECK(exact[gmis::best_scheme(table, costs, source).best].score <= least * (1.0 + 0.02));
  }
}

TEST_CASE("best_scheme: what is best depends on the problem and on the costs", "[mis]") {
  gmis::Philox source(gmis_test::seed(11));
  const auto choose = [&](double share, CostModel costs) {
    const Problem problem(share);
    const gmis::TabulatedProblem table(Problem::f, problem.bumps, problem.nodes);
    return gmis::best_scheme(table, costs, source).chosen();
  };
  CHECK(choose(1.0, {1000.0, 1.0}).group_size == 0);
  CHECK(choose(1.0, {1000.0, 1.0}).scheme == Scheme::N1);  // all weights are alike; R1 is level, and draws its indices
  CHECK(choose(0.02, {1.0, 1000.0}).scheme == Scheme::N3);
  CHECK(choose(0.02, {1.0, 1000.0}).group_size == 0);
  CHECK(choose(0.6, {1000.0, 1.0}).density_evaluations < 64.0);
}

TEST_CASE("no variance that a pilot gives is negative, however short it is", "[mis]") {
  const std::array<test::Ramp, 3> ramps{{{1.5}, {-1.0}, {0.3}}};
  const auto mixture = [&](double x) { return ramps[0].pdf(x) + ramps[1].pdf(x) + ramps[2].pdf(x); };
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    gmis::Philox source(gmis_test::seed(seed));
    const gmis::PilotSamples pilot(mixture, ramps, 2, source);
    CAPTURE(seed);
    for (const Scheme scheme : gmis::all_schemes) CHECK(exact_variance(scheme, pilot.problem()) > -1e-12);
    CHECK(exact_moments(gmis::Groups<>(3, 2), pilot.problem()).variance > -1e-12);
  }
}

TEST_CASE("best_scheme: of schemes without variance the cheapest wins", "[mis]") {
  const std::array<test::Ramp, 4> ramps{{{1.0}, {1.0}, {1.0}, {1.0}}};
  gmis::Philox source(gmis_test::seed(2));
  const gmis::PilotSamples pilot([](double x) { return 3.0 * (1.0 + (x - 0.5)); }, ramps, 5, source);
  const auto choice = gmis::best_scheme(pilot.problem(), {10.0, 10.0}, source);
  for (const auto& candidate : choice.candidates) CHECK(candidate.variance < 1e-14);
  CHECK(choice.chosen().scheme == Scheme::N1);
  CHECK(choice.chosen().density_evaluations == 4.0);
}

TEST_CASE("best_scheme never picks a scheme that the pilot knows to be biased", "[mis]") {
  const std::array<test::Uniform, 4> halves{{{0.0, 0.5}, {0.0, 0.5}, {0.5, 1.0}, {0.5, 1.0}}};
  gmis::Philox source(gmis_test::seed(2));
  const gmis::PilotSamples pilot([](double x) { return 1.0 + x; }, halves, 50, source);
  const auto choice = gmis::best_scheme(pilot.problem(), {1000.0, 1.0}, source);
  for (const auto& candidate : choice.candidates) {
    const bool covers = candidate.group_size >= 2 || !needs_full_support(candidate.scheme);
    CAPTURE(name_of(candidate.scheme), candidate.group_size);
    // Strided groups of two and of three (two and two) hold one proposal of each half.
    CHECK(candidate.is_unbiased == covers);
  }
  CHECK(choice.chosen().group_size == 2);
}

TEST_CASE("best_scheme is a function of the seed, and works with logarithms out of range", "[mis]") {
  const auto f_log = [](double x) { return gmis::LogValue<double>{std::log(test::Normal{0.2, 0.9}.pdf(x)) - 2000.0}; };
  const auto f = [](double x) { return test::Normal{0.2, 0.9}.pdf(x); };
  const std::array<Far, 8> far{{{-1.0}, {-0.6}, {-0.3}, {0.0}, {0.3}, {0.5}, {0.8}, {1.0}}};
  std::vector<test::Normal> near;
  for (const Far& proposal : far) near.push_back({proposal.mean, 1.0});
  const auto table_of = [](const auto& integrand, const auto& proposals) {
    gmis::Philox source(gmis_test::seed(9));
    const gmis::PilotSamples pilot(integrand, proposals, 100, source);
    return gmis::best_scheme(pilot.problem(), {10.0, 10.0}, source);
  };
  const auto once = table_of(f, near), again = table_of(f, near), from_logs = table_of(f_log, far);
  REQUIRE(once.candidates.size() == from_logs.candidates.size());
  CHECK(once.best == again.best);
  CHECK(once.best == from_logs.best);
  for (std::size_t i = 0; i < once.candidates.size(); ++i) {
    CHECK(once.candidates[i].variance == again.candidates[i].variance);
    CHECK(once.candidates[i].variance == Approx(from_logs.candidates[i].variance).epsilon(1e-9));
  }
}

TEST_CASE("a pilot of proposals that fail knows their share", "[mis]") {
  struct Half {  // of a uniform density, the other half failing
    std::optional<double> sample(gmis::Philox& source) const {
      const double x = gmis::uniform<double>(source);
      return gmis::uniform<double>(source) < 0.5 ? std::optional<double>(x) : std::nullopt;
    }
    double pdf(double x) const { return x >= 0.0 && x < 1.0 ? 0.5 : 0.0; }
  };
  const std::array<Half, 1> proposals{};
  gmis::Philox source(gmis_test::seed(6));
  const gmis::PilotSamples pilot([](double) { return 1.0; }, proposals, 4000, source);
  // f/q is 2 or 0, each half the time: variance 1; its estimate 4 p̂ (1 − p̂) is within 0.01 of
  // it for p̂ within 5 standard deviations of 1/2.
  CHECK(exact_variance(Scheme::R1, pilot.problem()) == Approx(1.0).margin(0.01));
}

// All weights are alike: what rounding leaves of each variance of 0 must not choose between a cheap
// and a dear scheme.
TEST_CASE("best_scheme: rounding does not decide between variances of 0", "[mis]") {
  gmis::Philox source(gmis_test::seed(12));
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 3);
  for (int trial = 0; trial < 40; ++trial) {
    const test::Ramp ramp{3.6 * gmis::uniform<double>(source) - 1.8};
    const double scale = std::exp(20.0 * gmis::uniform<double>(source) - 10.0);
    const std::vector<test::Ramp> ramps(2 + static_cast<std::size_t>(trial) % 5, ramp);
    const gmis::TabulatedProblem table([&](double x) { return scale * ramp.pdf(x); }, ramps, nodes);
    const auto choice = gmis::best_scheme(table, {1.0, 1.0}, source);
    CHECK(choice.chosen().variance == 0.0);
    CHECK(choice.chosen().scheme == Scheme::N1);
    CHECK(choice.chosen().group_size == 0);
  }
}
