#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <limits>
#include <tuple>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

constexpr std::size_t dimension = 100;
using Point = std::array<double, dimension>;

/// Independent normals in 100 dimensions; its density is about 1e-300 or less for sd ≥ 100 and
/// underflows.
struct Normal100 {
  double mean, sd;
  Point sample(gmis::UniformSource auto& source) const {
    Point x;
    for (double& coordinate : x) coordinate = test::Normal{mean, sd}.sample(source);
    return x;
  }
  double log_pdf(const Point& x) const {
    double squares = 0.0;
    for (const double coordinate : x) squares += (coordinate - mean) * (coordinate - mean);
    return -0.5 * squares / (sd * sd) - static_cast<double>(dimension) * std::log(sd * std::sqrt(2.0 * test::pi));
  }
};

/// The same without logarithms: what happens then.
struct UnderflowingNormal100 : Normal100 {
  double pdf(const Point& x) const { return std::exp(Normal100::log_pdf(x)); }
  double log_pdf(const Point&) const = delete;
};

}  // namespace

TEST_CASE("LogSum is log-sum-exp", "[mis]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> cases{{0.0},           {1.0, 2.0, 3.0},      {-1000.0, -1001.0, -999.5},
                                               {1000.0, 0.0},   {-5000.0, 5000.0, 1}, {-infinity, 2.0, -infinity},
                                               {700, 710, 720}, {-745.0, -746.0}};
  for (const auto& terms : cases) {
    long double largest = -std::numeric_limits<long double>::infinity();
    for (const double term : terms) largest = std::max(largest, static_cast<long double>(term));
    long double sum = 0.0L;
    for (const double term : terms) sum += std::exp(static_cast<long double>(term) - largest);
    gmis::LogSum<double> log_sum;
    for (const double term : terms) log_sum.add(term);
    CHECK(log_sum.log() == Approx(static_cast<double>(largest + std::log(sum))).epsilon(1e-14));
  }
  gmis::LogSum<double> empty, zeros, infinite, invalid;
  zeros.add(-infinity);
  infinite.add(3.0);
  infinite.add(infinity);
  infinite.add(4.0);
  invalid.add(1.0);
  invalid.add(std::nan(""));
  invalid.add(2.0);
  CHECK(empty.log() == -infinity);
  CHECK(zeros.log() == -infinity);
  CHECK(infinite.log() == infinity);
  CHECK(std::isnan(invalid.log()));
}

// f is itself a density: every estimate of 1 has a known answer although all densities are below
// 1e-308. 15 z-tests, false-alarm rate 1e-4 for the family.
TEST_CASE("densities of 100-dimensional normals, far below the range of double", "[mis]") {
  const std::array<Normal100, 2> proposals{{{0.0, 5000.0}, {100.0, 5100.0}}};
  const Normal100 target{30.0, 4990.0};
  const auto f = [&](const Point& x) { return gmis::LogValue<double>{target.log_pdf(x)}; };
  const double level = test::sidak_level(1e-4, 15);
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(name_of(selection), name_of(weighting));
      gmis::Philox source(gmis_test::seed(9));
      std::vector<double> means(300);
      for (double& mean : means) {
        const auto estimate = gmis::estimate(selection, weighting, f, proposals, 1, source);
        REQUIRE(estimate.rejected.total() == 0);
        mean = estimate.mean;
      }
      const auto moments = test::moments_of(means);
      CHECK(test::mean_p_value(moments, 1.0) > level);
      CHECK(moments.standard_error < 0.1);
    }

  // Without log_pdf, the same proposals are found out: every sample is rejected and counted, none
  // is summed.
  const std::array<UnderflowingNormal100, 2> underflowing{{{{0.0, 5000.0}}, {{100.0, 5100.0}}}};
  gmis::Philox source(gmis_test::seed(9));
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](const Point&) { return 1.0; }, underflowing, 10, source);
  CHECK(estimate.rejected.zero_density == 20);
  CHECK(estimate.mean == 0.0);
}

TEST_CASE("plain densities and logarithms give the same estimate", "[mis]") {
  struct LogNormal {
    test::Normal normal;
    double sample(gmis::Philox& source) const { return normal.sample(source); }
    double log_pdf(double x) const { return std::log(normal.pdf(x)); }
  };
  const std::array<test::Normal, 2> plain{{{0.0, 1.0}, {1.0, 2.0}}};
  const std::array<LogNormal, 2> logarithms{{{plain[0]}, {plain[1]}}};
  const auto mixed = std::make_tuple(plain[0], logarithms[1]);  // one logarithm makes the whole set use them
  const auto f = [](double x) { return std::exp(-x * x); };
  const auto log_f = [](double x) { return gmis::LogValue<double>{-x * x}; };
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(name_of(selection), name_of(weighting));
      const auto run = [&](auto integrand, const auto& proposals) {
        gmis::Philox source(gmis_test::seed(77));
        return gmis::estimate(selection, weighting, integrand, proposals, 50, source).mean;
      };
      const double expected = run(f, plain);
      CHECK(run(f, logarithms) == Approx(expected).epsilon(1e-12));
      CHECK(run(f, mixed) == Approx(expected).epsilon(1e-12));
      CHECK(run(log_f, plain) == Approx(expected).epsilon(1e-12));
      CHECK(run(log_f, mixed) == Approx(expected).epsilon(1e-12));
    }
}

TEST_CASE("f over a density outside the range of double, where the ratio is inside", "[mis]") {
  const gmis::LogDensity<double> tiny{-800.0};
  CHECK(gmis::ratio<double>(std::exp(-700.0), tiny) == Approx(std::exp(100.0)).epsilon(1e-12));
  CHECK(gmis::ratio<double>(gmis::LogValue<double>{-900.0, -1.0}, tiny) == Approx(-std::exp(-100.0)).epsilon(1e-12));
}

// 1/φ is above e^710, the range of double.
TEST_CASE("f = 0 over a density of e^-1500 is zero, in each channel", "[mis]") {
  const gmis::LogDensity<double> tiny{-1500.0};
  CHECK(gmis::ratio<double>(0.0, tiny) == 0.0);
  CHECK(gmis::ratio<double>(0.0F, tiny) == 0.0);
  CHECK(gmis::ratio<double>(1.0, tiny) == std::numeric_limits<double>::infinity());
  struct Far {
    double sample(gmis::Philox& source) const { return gmis::uniform<double>(source); }
    double log_pdf(double x) const { return x < 0.5 ? -1500.0 : 0.0; }
  };
  const std::array<Far, 2> proposals{};
  gmis::Philox source(gmis_test::seed(9));
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](double x) { return glm::dvec2(0.0, x < 0.5 ? 0.0 : 2.0); },
                                                         proposals, 500, source);
  CHECK(estimate.rejected.total() == 0);
  CHECK(estimate.mean.x == 0.0);
  CHECK(estimate.mean.y > 0.5);
}
