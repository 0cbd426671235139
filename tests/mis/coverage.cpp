#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Scheme;

std::vector<double> grid() {
  std::vector<double> points;
  for (int i = 0; i < 100; ++i) points.push_back((i + 0.5) / 100.0);
  return points;
}
double box(double x) {
  return x < 0.9 ? 1.0 : 0.0;
}

// Uniform on [0, 1], but for the density that it states on half of it.
struct Broken {
  double bad;

  double sample(gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(double x) const { return x < 0.5 ? bad : 1.0; }
};

}  // namespace

TEST_CASE("coverage: full support allows every scheme", "[mis]") {
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  const auto coverage = gmis::check_coverage(box, ramps, grid());
  CHECK(coverage.probes == 100);
  CHECK(coverage.nonzero == 90);
  CHECK(coverage.uncovered == 0);
  CHECK(coverage.partly_uncovered == 0);
  CHECK_FALSE(coverage.uncovered_example.has_value());
  for (const Scheme scheme : gmis::all_schemes) CHECK(coverage.allows(scheme));
}

TEST_CASE("coverage: together but not each allows R3 and N3 alone", "[mis]") {
  const std::array<test::Uniform, 2> halves{{{0.0, 0.5}, {0.4, 1.0}}};
  const auto coverage = gmis::check_coverage(box, halves, grid());
  CHECK(coverage.uncovered == 0);
  CHECK(coverage.partly_uncovered == 80);  // all of [0, 0.9) but [0.4, 0.5)
  CHECK(coverage.partly_uncovered_example.value() == Approx(0.005));
  for (const Scheme scheme : gmis::all_schemes) CHECK(coverage.allows(scheme) == !needs_full_support(scheme));
}

TEST_CASE("coverage: a hole allows no scheme, unless f is zero there", "[mis]") {
  const std::array<test::Uniform, 2> with_hole{{{0.0, 0.5}, {0.6, 1.0}}};
  const auto coverage = gmis::check_coverage(box, with_hole, grid());
  CHECK(coverage.uncovered == 10);
  CHECK(coverage.uncovered_example.value() == Approx(0.505));
  for (const Scheme scheme : gmis::all_schemes) CHECK_FALSE(coverage.allows(scheme));

  const std::array<test::Uniform, 1> short_of_one{{{0.0, 0.9}}};
  CHECK(gmis::check_coverage(box, short_of_one, grid()).allows(Scheme::R1));
}

TEST_CASE("coverage: probing with a proposal", "[mis]") {
  const std::array<test::Uniform, 1> narrow{{{0.0, 0.5}}};
  gmis::Philox source(gmis_test::seed(2));
  const auto coverage = gmis::check_coverage(box, narrow, test::Uniform{}, 1000, source);
  CHECK(coverage.probes == 1000);
  // 40 % of the probes: 400 ± 15.5; five standard deviations.
  CHECK(std::abs(static_cast<double>(coverage.uncovered) - 400.0) < 78.0);
}

TEST_CASE("coverage: where f is not finite nothing is judged", "[mis]") {
  const std::array<test::Uniform, 1> all{};
  const auto coverage = gmis::check_coverage([](double x) { return x < 0.1 ? std::nan("") : 1.0; }, all, grid());
  CHECK(coverage.non_finite == 10);
  CHECK(coverage.bad_density == 0);
  CHECK(coverage.nonzero == 90);
  CHECK(coverage.allows(Scheme::N3));
}

TEST_CASE("coverage: a density that is not finite allows no scheme", "[mis]") {
  for (const double bad : {std::nan(""), -1.0, std::numeric_limits<double>::infinity()}) {
    const std::array<Broken, 1> broken{{{bad}}};
    const auto coverage = gmis::check_coverage(box, broken, grid());
    CHECK(coverage.non_finite == 50);
    CHECK(coverage.bad_density == 50);
    CHECK(coverage.nonzero == 40);
    for (const Scheme scheme : gmis::all_schemes) CHECK_FALSE(coverage.allows(scheme));
    CHECK_FALSE(coverage.allows_groups());
  }
}

// The scheme cannot see the hole itself: it reports no error and is wrong by what is missing.
TEST_CASE("an estimate does not notice a hole", "[mis]") {
  const std::array<test::Uniform, 1> narrow{{{0.0, 0.5}}};
  gmis::Philox source(gmis_test::seed(2));
  const auto estimate = gmis::estimate<Scheme::N3>(box, narrow, 10, source);
  CHECK(estimate.rejected.total() == 0);
  CHECK(estimate.mean == Approx(0.5));
}
