#include "gmis/mis/batched_round.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "gmis/core/density_tests.hpp"
#include "gmis/core/exp_in_lanes.hpp"
#include "gmis/mis/diagnostics/quadrature.hpp"
#include "gmis/mis/location_scale.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

double error_in_units(double x) {
  const long double exact = std::exp(static_cast<long double>(x));
  const double nearest = static_cast<double>(exact);
  const double unit = std::nextafter(nearest, infinity) - nearest;
  return static_cast<double>(std::abs(static_cast<long double>(gmis::exp_in_lanes(x)) - exact)) / unit;
}

/// One proposal of a set, on its own.
template <class Set>
struct Member {
  const Set& set;
  std::size_t i;
  auto sample(gmis::UniformSource auto& source) const { return set.sample(i, source); }
  auto pdf(typename Set::Value x) const { return set.pdf(i, x); }
};

/// Every other sample of the uniform density on [0, 1) is not made.
struct Failing {
  double keep;
  std::optional<double> sample(gmis::UniformSource auto& source) const {
    const double x = gmis::uniform<double>(source);
    if (gmis::uniform<double>(source) >= keep) return std::nullopt;
    return x;
  }
  double pdf(double x) const { return x >= 0.0 && x < 1.0 ? keep : 0.0; }
};

template <class E>
void check_equal(const E& a, const E& b) {
  CHECK(a.mean == b.mean);
  CHECK(a.variance == b.variance);
  CHECK(a.standard_error == b.standard_error);
  CHECK(a.rounds == b.rounds);
  CHECK(a.samples == b.samples);
  CHECK(a.density_evaluations == b.density_evaluations);
  CHECK(a.integrand_evaluations == b.integrand_evaluations);
  CHECK(a.failed_samples == b.failed_samples);
  CHECK(a.rejected == b.rejected);
}

/// Batches against one sample at a time: the same numbers in every member.
template <class F, class P, class A = gmis::EqualAllocation>
void check_same(const F& f, const P& proposals, std::uint64_t seed, const A& allocation = {}) {
  gmis::Philox one(seed), many(seed);
  check_equal(gmis::estimate_in_batches(f, proposals, 40, many, allocation),
              gmis::estimate<gmis::Scheme::N3>(f, proposals, 40, one, allocation));
  CHECK(one() == many());
}

std::vector<test::Normal> normals(std::size_t n) {
  std::vector<test::Normal> result;
  for (std::size_t i = 0; i < n; ++i)
    result.push_back({3.0 * std::sin(static_cast<double>(i)), 0.5 + 0.1 * static_cast<double>(i % 7)});
  return result;
}

}  // namespace

TEST_CASE("exponential in lanes: within 1.5 units in the last place, and the ends", "[mis]") {
  std::mt19937_64 engine(gmis_test::seed(301));
  double largest = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double u = gmis::uniform<double>(engine);
    const double x = i % 2 == 0 ? -708.0 + u * (709.78 + 708.0) : 2.0 * u - 1.0;
    largest = std::max(largest, error_in_units(x));
  }
  for (int n = -1021; n <= 1023; ++n)  // where the nearest multiple of ln 2 changes
    for (const double offset : {-1e-9, 0.0, 1e-9})
      largest = std::max(largest, error_in_units(std::clamp((n + 0.5) * 0.6931471805599453 + offset, -708.0, 709.78)));
  CAPTURE(largest);
  CHECK(largest < 1.5);
  CHECK(gmis::exp_in_lanes(0.0) == 1.0);
  CHECK(gmis::exp_in_lanes(-0.0) == 1.0);
  CHECK(error_in_units(709.78) < 1.5);
  CHECK(error_in_units(-708.0) < 1.5);
  CHECK(gmis::exp_in_lanes(-708.1) == 0.0);
  CHECK(gmis::exp_in_lanes(-infinity) == 0.0);
  for (const double sign : {-1.0, 1.0}) {
    const double of_nan = gmis::exp_in_lanes(std::copysign(std::numeric_limits<double>::quiet_NaN(), sign));
    CHECK((std::isnan(of_nan) || of_nan == 0.0));
  }
  static_assert(gmis::exp_in_lanes(0.0) == 1.0);
}

// 3 shapes × 2 members: six chi-square tests, false-alarm rate 1e-4 in all.
TEST_CASE("sets of location and scale: density in closed form, mass one, samples that fit", "[mis]") {
  const std::vector<double> locations{0.0, -2.5}, scales{1.0, 0.3};
  const auto check = [&](auto shape, auto closed_form, double reach) {
    const gmis::LocationScaleSet<decltype(shape)> set(locations, scales);
    REQUIRE(set.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
      for (const double z : {-30.0, -3.0, -0.7, 0.0, 1e-9, 0.4, 2.0, 25.0}) {
        const long double exact = closed_form(static_cast<long double>(z)) / static_cast<long double>(scales[i]);
        CHECK(set.pdf(i, locations[i] + z * scales[i]) ==
              Approx(static_cast<double>(exact)).epsilon(1e-10).margin(1e-300));
      }
      gmis::Philox source(gmis_test::seed(302));
      const auto result = gmis::check_proposal(Member<decltype(set)>{set, i}, locations[i] - reach * scales[i],
                                               locations[i] + reach * scales[i], source);
      CAPTURE(i, result.test.p_value, result.integral, result.outside);
      CHECK(result.passes(test::sidak_level(1e-4, 6)));
    }
  };
  const long double pi = std::acos(-1.0L);
  check(
      gmis::shapes::Cauchy{}, [&](long double z) { return 1.0L / (pi * (1.0L + z * z)); }, 40.0);
  check(
      gmis::shapes::Logistic{}, [](long double z) { return std::exp(-z) / std::pow(1.0L + std::exp(-z), 2.0L); }, 25.0);
  check(
      gmis::shapes::Normal{}, [&](long double z) { return std::exp(-z * z / 2.0L) / std::sqrt(2.0L * pi); }, 8.0);
}

// The middle of the first step of `uniform`, the number 1/4, and the middle of the last step.
template <std::floating_point T>
void check_inversions() {
  struct Fixed {  // words of equal bits
    std::uint64_t word;
    static constexpr std::uint64_t min() { return 0; }
    static constexpr std::uint64_t max() { return ~std::uint64_t(0); }
    std::uint64_t operator()() const { return word; }
  };
  const long double step = std::numeric_limits<T>::epsilon() / 2.0L, pi = std::acos(-1.0L);
  for (const auto& [word, u] : {std::pair<std::uint64_t, long double>(0, step / 2),
                                {std::uint64_t(1) << 62U, 0.25L + step / 2},
                                {~std::uint64_t(0), 1.0L - step / 2}}) {
    Fixed source{word};
    CAPTURE(std::numeric_limits<T>::digits, static_cast<double>(u));
    const T logistic = gmis::shapes::Logistic::sample<T>(source), cauchy = gmis::shapes::Cauchy::sample<T>(source);
    CHECK(logistic ==
          Approx(static_cast<double>(std::log(u / (1.0L - u)))).epsilon(4 * std::numeric_limits<T>::epsilon()));
    // π (u − 1/2) is rounded; next to a pole that is a large part of the distance from it.
    const long double exact = -1.0L / std::tan(pi * u);
    CHECK(cauchy / static_cast<T>(exact) > T(0.5));
    CHECK(cauchy / static_cast<T>(exact) < T(3));
  }
}

TEST_CASE("shapes on the line: samples at the ends of the source's numbers are quantiles") {
  check_inversions<float>();
  check_inversions<double>();
}

TEST_CASE("sets of location and scale: all densities at once have the bits of one at a time", "[mis]") {
  std::mt19937_64 engine(gmis_test::seed(303));
  for (const std::size_t n : {1U, 2U, 5U, 8U, 64U, 67U}) {
    std::vector<double> locations(n), scales(n);
    for (double& location : locations) location = 10.0 * gmis::uniform<double>(engine) - 5.0;
    for (double& scale : scales) scale = 0.1 + gmis::uniform<double>(engine);
    const gmis::LocationScaleSet<gmis::shapes::Normal> normal(locations, scales);
    const gmis::LocationScaleSet<gmis::shapes::Logistic, double, 67> logistic(locations, scales);
    std::vector<double> out(n);
    for (int i = 0; i < 50; ++i) {
      const double x = 20.0 * gmis::uniform<double>(engine) - 10.0;
      normal.pdfs(x, out);
      for (std::size_t k = 0; k < n; ++k) CHECK(out[k] == normal.pdf(k, x));
      logistic.pdfs(x, out);
      for (std::size_t k = 0; k < n; ++k) CHECK(out[k] == logistic.pdf(k, x));
    }
  }
}

TEST_CASE("sets of location and scale: estimates as with proposals one by one", "[mis]") {
  const auto proposals = normals(64);
  std::vector<double> locations, scales;
  for (const auto& proposal : proposals) {
    locations.push_back(proposal.mean);
    scales.push_back(proposal.sd);
  }
  const auto f = [](double x) { return std::exp(-std::abs(x)); };
  const gmis::LocationScaleSet<gmis::shapes::Normal> set(locations, scales);
  for (const auto scheme : gmis::all_schemes) {
    gmis::Philox a(gmis_test::seed(304)), b(gmis_test::seed(304));
    const auto one_by_one = gmis::estimate(scheme, f, proposals, 200, a);
    const auto side_by_side = gmis::estimate(scheme, f, set, 200, b);
    CAPTURE(name_of(scheme));
    CHECK(side_by_side.mean == Approx(one_by_one.mean).epsilon(1e-12));
    CHECK(side_by_side.variance.value() == Approx(one_by_one.variance.value()).epsilon(1e-9));
    CHECK(a() == b());
  }
}

TEST_CASE("sets of location and scale: arguments that cannot serve", "[mis]") {
  using Set = gmis::LocationScaleSet<gmis::shapes::Normal>;
  using Numbers = std::vector<double>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(Set(Numbers{}, Numbers{}), std::invalid_argument);
  CHECK_THROWS_AS(Set(Numbers{1.0}, Numbers{1.0, 1.0}), std::invalid_argument);
  for (const double scale : {0.0, -1.0, nan, infinity, 5e-324})
    CHECK_THROWS_AS(Set(Numbers{1.0}, Numbers{scale}), std::invalid_argument);
  for (const double location : {nan, infinity, -infinity})
    CHECK_THROWS_AS(Set(Numbers{location}, Numbers{1.0}), std::invalid_argument);
  using Small = gmis::LocationScaleSet<gmis::shapes::Normal, double, 2>;
  CHECK_THROWS_AS(Small(Numbers{1.0, 2.0, 3.0}, Numbers{1.0, 1.0, 1.0}), std::invalid_argument);
}

TEST_CASE("batches: bit for bit what one sample at a time gives, for every number of proposals", "[mis]") {
  const auto f = [](double x) { return x * x * std::exp(-std::abs(x)); };
  for (std::size_t n = 1; n <= 40; ++n) {
    CAPTURE(n);
    check_same(f, normals(n), gmis_test::seed(305));
  }
  check_same(f, normals(64), gmis_test::seed(306));
  check_same(f, normals(100), gmis_test::seed(307));
  const std::array<test::Ramp, 3> array{{{-1.0}, {0.3}, {1.5}}};
  check_same(f, array, gmis_test::seed(308));
  check_same(f, std::make_tuple(array[0], test::Uniform{}, test::Uniform{0.2, 0.7}), gmis_test::seed(309));
  const std::array<test::TiltedSphere, 2> sphere{{{0.2F}, {0.9F}}};
  check_same([](const glm::vec3& d) { return d * d.z; }, sphere, gmis_test::seed(310));
  const std::vector<double> locations{0.0, 1.0, -3.0, 2.0, 5.0, -1.0, 0.5, 0.1, 0.2}, scales(9, 0.8);
  check_same(f, gmis::LocationScaleSet<gmis::shapes::Logistic>(locations, scales), gmis_test::seed(311));
}

TEST_CASE("batches: allocations, samples that fail, densities that are wrong", "[mis]") {
  const auto f = [](double x) { return 1.0 + x; };
  const std::vector<test::Ramp> ramps{{-1.0}, {0.3}, {1.5}, {0.0}};
  check_same(f, ramps, gmis_test::seed(312), gmis::SampleAllocation({5, 0, 37, 1}));
  check_same(f, ramps, gmis_test::seed(313), gmis::SampleAllocation({0.1, 0.2, 0.3, 0.4}, 50));
  std::vector<Failing> failing(21, Failing{0.5});
  failing[20].keep = 0.0;  // every sample fails
  check_same(f, failing, gmis_test::seed(314));
  const std::vector<Failing> never(17, Failing{0.0});
  check_same(f, never, gmis_test::seed(315));
  for (const double fault : {-1.0, 0.0, infinity, std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<test::FaultyDensity> faulty(18, test::FaultyDensity{1.0});
    faulty[3].fault = faulty[16].fault = fault;
    CAPTURE(fault);
    check_same(f, faulty, gmis_test::seed(316));
    check_same(f, faulty, gmis_test::seed(316), gmis::SampleAllocation(std::vector<int>(18, 5)));
  }
  check_same([](double x) { return x < 0.5 ? std::numeric_limits<double>::quiet_NaN() : 1.0 + x; }, ramps,
             gmis_test::seed(317));
}

TEST_CASE("batches: arguments that cannot serve", "[mis]") {
  gmis::Philox source(1);
  const auto f = [](double x) { return x; };
  const auto one = normals(1);
  CHECK_THROWS_AS(gmis::estimate_in_batches(f, std::vector<test::Normal>{}, 3, source), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_in_batches(f, one, 0, source), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_in_batches(f, one, 3, source, gmis::SampleAllocation({1, 2})), std::invalid_argument);
}
