#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis/diagnostics.hpp"
#include "mis/oracle_cases.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Scheme;

struct Oracle {
  Scheme scheme;
  double case_b, case_d;
};
// By quadrature on [-30, 30], found twice independently of this library.
constexpr std::array<Oracle, 6> oracles{{{Scheme::R1, 6.54749, 5.60486},
                                         {Scheme::R2, 0.886525, 2.96171},
                                         {Scheme::R3, 0.0513829, 0.350401},
                                         {Scheme::N1, 6.54749, 5.60486},
                                         {Scheme::N2, 2.27007, 2.97763},
                                         {Scheme::N3, 0.0505404, 0.318557}}};

}  // namespace

TEST_CASE("exact variances of cases B and D", "[mis]") {
  const gmis::TabulatedProblem b = test::case_b(), d = test::case_d();
  for (const Oracle& oracle : oracles) {
    CAPTURE(name_of(oracle.scheme));
    CHECK(gmis::exact_variance(oracle.scheme, b) == Approx(oracle.case_b).epsilon(5e-6));
    CHECK(gmis::exact_variance(oracle.scheme, d) == Approx(oracle.case_d).epsilon(5e-6));
    CHECK(gmis::exact_mean(oracle.scheme, b) == Approx(1.0).epsilon(1e-12));
    CHECK(gmis::exact_mean(oracle.scheme, d) == Approx(1.0).epsilon(1e-12));
  }
}

// With all proposals equal to f, every ratio is 1 and nothing varies; with one proposal all schemes coincide.
TEST_CASE("exact variances in the limits", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 4);
  const std::vector<test::Ramp> same(4, test::Ramp{1.0});
  const gmis::TabulatedProblem perfect([](double x) { return test::Ramp{1.0}.pdf(x); }, same, nodes);
  const std::array<test::Ramp, 1> one{{{0.0}}};
  const gmis::TabulatedProblem single([](double x) { return x; }, one, nodes);
  for (const Scheme scheme : gmis::all_schemes) {
    CHECK(std::abs(gmis::exact_variance(scheme, perfect)) < 1e-14);
    CHECK(gmis::exact_variance(scheme, single) == Approx(1.0 / 12.0));  // ∫ x² − (∫ x)²
  }
}

// Jensen's order, on the cases and on families of random bumps.
TEST_CASE("R1 = N1 >= N2 >= R3 >= N3 and R1 >= R2", "[mis]") {
  gmis::Philox source(gmis_test::seed(3));
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<test::Ramp> ramps(2 + static_cast<std::size_t>(trial) % 4);
    for (auto& ramp : ramps) ramp.slope = 3.6 * gmis::uniform<double>(source) - 1.8;
    const double frequency = 10.0 * gmis::uniform<double>(source);
    const std::array<double, 2> ends{0.0, 1.0};
    const auto nodes = gmis::composite_gauss_legendre(ends, 8);
    const gmis::TabulatedProblem problem([&](double x) { return 1.0 + std::sin(frequency * x); }, ramps, nodes);
    const auto variance = [&](Scheme scheme) { return gmis::exact_variance(scheme, problem); };
    const double slack = 1e-12;
    CHECK(variance(Scheme::R1) == Approx(variance(Scheme::N1)).epsilon(1e-10));
    CHECK(variance(Scheme::N1) >= variance(Scheme::N2) - slack);
    CHECK(variance(Scheme::N2) >= variance(Scheme::R3) - slack);
    CHECK(variance(Scheme::R3) >= variance(Scheme::N3) - slack);
    CHECK(variance(Scheme::R1) >= variance(Scheme::R2) - slack);
  }
}

// The direct sums over all N^N indices and all N! orders, term by term as the definitions read.
TEST_CASE("sums over multisets and subsets equal the sums over all draws", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 4);
  const std::array<test::Ramp, 3> ramps{{{-1.9}, {0.3}, {1.5}}};
  const auto f = [](double x) { return 1.0 + x * x; };
  const gmis::TabulatedProblem problem(f, ramps, nodes);
  const auto integrate = [&](auto g) {
    double sum = 0.0;
    for (const auto& node : nodes) sum += node.weight * g(node.x);
    return sum;
  };
  const double integral = integrate(f);
  double r2 = 0.0, n2 = 0.0;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto phi = [&](double x) { return (ramps[a].pdf(x) + ramps[b].pdf(x) + ramps[c].pdf(x)) / 3.0; };
        double squares = 0.0;
        for (const std::size_t j : {a, b, c}) {
          const double m = integrate([&](double x) { return f(x) * ramps[j].pdf(x) / phi(x); });
          squares += m * m;
        }
        r2 += (integrate([&](double x) { return f(x) * f(x) / phi(x); }) / 3.0 - squares / 9.0) / 27.0;
        if (a == b || b == c || a == c) continue;
        const auto last = [&](double x) { return ramps[c].pdf(x); };
        const auto last_two = [&](double x) { return (ramps[b].pdf(x) + ramps[c].pdf(x)) / 2.0; };
        const double second_moments = integrate([&](double x) { return f(x) * f(x) / phi(x); }) +
                                      integrate([&](double x) { return f(x) * f(x) / last_two(x); }) +
                                      integrate([&](double x) { return f(x) * f(x) / last(x); });
        n2 += (second_moments / 9.0 - integral * integral / 3.0) / 6.0;
      }
  CHECK(gmis::exact_variance(Scheme::R2, problem) == Approx(r2).epsilon(1e-12));
  CHECK(gmis::exact_variance(Scheme::N2, problem) == Approx(n2).epsilon(1e-12));
}

namespace {

/// p-value that an average has the expectation `exact`: its interval of 99 % is 2.576 standard errors wide each way.
double p_value(const gmis::AveragedVariance& averaged, double exact) {
  return test::normal_p_value((averaged.value - exact) / (averaged.half_width / 2.5758293035489004));
}

}  // namespace

// Six averages in this case and the next; false-alarm rate 1e-4 in all.
TEST_CASE("averaged variances enclose the exact ones", "[mis]") {
  const gmis::TabulatedProblem b = test::case_b(8), d = test::case_d(8);
  gmis::Philox source(gmis_test::seed(4));
  for (const Scheme scheme : {Scheme::R2, Scheme::N2})
    for (const gmis::TabulatedProblem* problem : {&b, &d}) {
      const auto averaged = gmis::averaged_variance(scheme, *problem, 8000, source);
      CAPTURE(name_of(scheme), averaged.value, averaged.half_width);
      CHECK(p_value(averaged, gmis::exact_variance(scheme, *problem)) > test::sidak_level(1e-4, 6));
      CHECK(averaged.half_width < 0.1 * averaged.value);
    }
}

TEST_CASE("exact R2 reaches ten proposals and exact N2 sixteen; beyond, the average takes over", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 1);
  const auto problem_of = [&](std::size_t n) {
    std::vector<test::Ramp> ramps(n);
    for (std::size_t k = 0; k < n; ++k)
      ramps[k].slope = -1.8 + 3.6 * static_cast<double>(k) / static_cast<double>(n - 1);
    return gmis::TabulatedProblem([](double x) { return 0.2 + x * x; }, ramps, nodes);
  };
  gmis::Philox source(gmis_test::seed(8));
  for (const auto& [scheme, n] : {std::pair(Scheme::R2, std::size_t{10}), std::pair(Scheme::N2, std::size_t{16})}) {
    const auto problem = problem_of(n);
    const auto averaged = gmis::averaged_variance(scheme, problem, 4000, source);
    CHECK(p_value(averaged, gmis::exact_variance(scheme, problem)) > test::sidak_level(1e-4, 6));
    const auto larger = problem_of(n + 1);
    CHECK_THROWS_AS(gmis::exact_variance(scheme, larger), std::invalid_argument);
    CHECK(gmis::averaged_variance(scheme, larger, 10, source).value > 0.0);
  }
}

TEST_CASE("the quadrature rule integrates what it should", "[mis]") {
  for (const std::size_t order : {std::size_t{1}, std::size_t{2}, std::size_t{5}, std::size_t{16}}) {
    const auto nodes = gmis::gauss_legendre(order);
    for (std::size_t degree = 0; degree < 2 * order; ++degree) {
      double sum = 0.0;
      for (const auto& node : nodes) sum += node.weight * std::pow(node.x, static_cast<double>(degree));
      CHECK(sum == Approx(degree % 2 == 1 ? 0.0 : 2.0 / static_cast<double>(degree + 1)).margin(1e-13));
    }
  }
}
