#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
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

// With all proposals equal to f, every ratio is 1 and nothing varies; with one proposal all schemes
// coincide.
TEST_CASE("exact variances in the limits", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 4);
  const std::vector<test::Ramp> same(4, test::Ramp{1.0});
  const gmis::TabulatedProblem perfect([](double x) { return test::Ramp{1.0}.pdf(x); }, same, nodes);
  const std::array<test::Ramp, 1> one{{{0.0}}};
  const gmis::TabulatedProblem single([](double x) { return x; }, one, nodes);
  for (const Scheme scheme : gmis::all_schemes) {
    CHECK(gmis::exact_variance(scheme, perfect) >= 0.0);
    CHECK(gmis::exact_variance(scheme, perfect) < 1e-14);
    CHECK(gmis::exact_variance(scheme, single) == Approx(1.0 / 12.0));  // ∫ x² − (∫ x)²
  }
}

// What remains is rounding, of either sign.
TEST_CASE("exact variances are not negative where f is proportional to the mixture", "[mis]") {
  const std::array<double, 3> ends{0.0, 0.3, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 8);
  for (int trial = 0; trial < 40; ++trial) {
    const std::array<test::Ramp, 2> proposals{{{0.037 * trial}, {-0.021 * trial}}};
    const double factor = 1.0 + 0.37 * trial;
    const auto f = [&](double x) { return factor * (proposals[0].pdf(x) + proposals[1].pdf(x)); };
    const double variance = gmis::exact_variance(Scheme::R3, gmis::TabulatedProblem(f, proposals, nodes));
    CAPTURE(trial);
    CHECK(variance >= 0.0);
    CHECK(variance <= 1e-13 * factor * factor);
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

/// p-value that an average has the expectation `exact`: its interval of 99 % is 2.576 standard
/// errors wide each way.
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

namespace {

/// Mean and variance of one round by its definition, a sum over all tuples of indices with their
/// probabilities, in long double. `phi(tuple, n, node)` is what sample n is divided by.
template <class Phi>
std::array<long double, 2> moments_over_tuples(const std::vector<std::vector<std::size_t>>& tuples,
                                               const std::vector<long double>& probabilities,
                                               const gmis::TabulatedProblem& problem, Phi phi) {
  long double mean = 0, second = 0;
  for (std::size_t t = 0; t < tuples.size(); ++t) {
    const long double n = static_cast<long double>(tuples[t].size());
    long double conditional_mean = 0, conditional_variance = 0;
    for (std::size_t m = 0; m < tuples[t].size(); ++m) {
      long double first = 0, square = 0;
      for (std::size_t i = 0; i < problem.node_count(); ++i) {
        const auto value = static_cast<long double>(problem.values()[i]) / phi(tuples[t], m, i);
        const long double mass = static_cast<long double>(problem.weights()[i]) *
                                 static_cast<long double>(problem.densities(tuples[t][m])[i]);
        first += mass * value;
        square += mass * value * value;
      }
      conditional_mean += first / n;
      conditional_variance += (square - first * first) / (n * n);
    }
    mean += probabilities[t] * conditional_mean;
    second += probabilities[t] * (conditional_variance + conditional_mean * conditional_mean);
  }
  return {mean, second - mean * mean};
}

}  // namespace

// Every scheme with weights α_i or counts n_i, by its definition.
TEST_CASE("exact variances with a sample allocation", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 3);
  const std::array<test::Ramp, 3> ramps{{{-1.7}, {0.4}, {1.6}}};
  const gmis::TabulatedProblem problem([](double x) { return std::exp(2.0 * x); }, ramps, nodes);
  const gmis::SampleAllocation allocation({0.5, 0.3, 0.2}, 4);
  REQUIRE(allocation.count(0) + allocation.count(1) + allocation.count(2) == 4);
  const auto q = [&](std::size_t k, std::size_t i) { return static_cast<long double>(problem.densities(k)[i]); };
  const auto alpha = [&](std::size_t k) { return static_cast<long double>(allocation.weight(k)); };

  std::vector<std::vector<std::size_t>> draws, orders;
  std::vector<long double> of_draws, of_orders;
  std::vector<std::size_t> slots;
  for (std::size_t slot = 0; slot < 4; ++slot) slots.push_back(allocation.proposal_of_slot(slot));
  for (std::size_t code = 0; code < 81; ++code) {
    std::vector<std::size_t> tuple;
    long double probability = 1;
    for (std::size_t rest = code, m = 0; m < 4; ++m, rest /= 3) {
      tuple.push_back(rest % 3);
      probability *= alpha(rest % 3);
    }
    draws.push_back(tuple);
    of_draws.push_back(probability);
  }
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  do {
    orders.push_back({slots[order[0]], slots[order[1]], slots[order[2]], slots[order[3]]});
    of_orders.push_back(1.0L / 24.0L);
  } while (std::next_permutation(order.begin(), order.end()));

  using Tuple = std::vector<std::size_t>;
  const auto own = [&](const Tuple& tuple, std::size_t m, std::size_t i) { return q(tuple[m], i); };
  const auto drawn = [&](const Tuple& tuple, std::size_t, std::size_t i) {
    long double sum = 0;
    for (const std::size_t k : tuple) sum += q(k, i) / static_cast<long double>(tuple.size());
    return sum;
  };
  const auto undrawn = [&](const Tuple& tuple, std::size_t m, std::size_t i) {
    long double sum = 0;
    for (std::size_t later = m; later < tuple.size(); ++later)
      sum += q(tuple[later], i) / static_cast<long double>(tuple.size() - m);
    return sum;
  };
  const auto by_weights = [&](const Tuple&, std::size_t, std::size_t i) {
    return alpha(0) * q(0, i) + alpha(1) * q(1, i) + alpha(2) * q(2, i);
  };
  const std::vector<Tuple> in_order{slots};
  const std::vector<long double> surely{1.0L};
  const std::array<std::array<long double, 2>, 6> expected{
      moments_over_tuples(draws, of_draws, problem, own),        moments_over_tuples(draws, of_draws, problem, drawn),
      moments_over_tuples(draws, of_draws, problem, by_weights), moments_over_tuples(in_order, surely, problem, own),
      moments_over_tuples(orders, of_orders, problem, undrawn),  moments_over_tuples(in_order, surely, problem, drawn)};
  for (const Scheme scheme : gmis::all_schemes) {
    CAPTURE(name_of(scheme));
    const auto moments = gmis::exact_moments(scheme, allocation, problem);
    const auto& [mean, variance] = expected[static_cast<std::size_t>(scheme)];
    CHECK(moments.mean == Approx(static_cast<double>(mean)).epsilon(1e-12));
    CHECK(moments.variance == Approx(static_cast<double>(variance)).epsilon(1e-10));
    // One sample of each proposal is what the shorter call is for.
    const auto equal = gmis::exact_moments(scheme, gmis::SampleAllocation({1, 1, 1}), problem);
    CHECK(equal.variance == Approx(gmis::exact_variance(scheme, problem)).epsilon(1e-12));
  }
  const gmis::SampleAllocation many({40, 40, 40, 40}), other({1, 1});
  CHECK_THROWS_AS(gmis::exact_moments(Scheme::R3, other, problem), std::invalid_argument);
  const std::array<test::Ramp, 4> four{{{-1.7}, {0.4}, {1.6}, {0.0}}};
  const gmis::TabulatedProblem larger([](double x) { return x; }, four, nodes);
  CHECK_THROWS_AS(gmis::exact_moments(Scheme::R2, many, larger), std::invalid_argument);
  CHECK_THROWS_AS(gmis::exact_moments(Scheme::N2, many, larger), std::invalid_argument);
}

// Binomial coefficients of these counts are outside the range of double. The exact moments of two
// proposals are sums over the number of samples of the first, here by logarithms.
TEST_CASE("exact moments of N2 and R2 with a thousand samples", "[mis]") {
  const std::array<test::Normal, 2> normals{{{-1.0, 2.0}, {1.0, 2.0}}};
  const std::array<double, 2> ends{-12.0, 12.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 8);
  const gmis::TabulatedProblem problem([](double x) { return test::Normal{0.0, 1.0}.pdf(x); }, normals, nodes);
  const auto log_binomial = [](double n, double k) {
    return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
  };
  std::vector<double> density(problem.node_count()), divided(problem.node_count());
  const auto divide = [&](double a, double b) {  // by the mean density of a samples of the first and b of the second
    for (std::size_t i = 0; i < density.size(); ++i)
      density[i] = a * problem.densities(0)[i] + b * problem.densities(1)[i];
    problem.divide(a + b, density.data(), divided.data());
  };
  using Counts = std::vector<std::uint32_t>;
  for (const Counts& counts : {Counts{1, 1030}, Counts{3, 1200}, Counts{2, 3}}) {
    CAPTURE(counts);
    const double n0 = counts[0], n1 = counts[1], n = n0 + n1;
    double second = 0.0;
    for (double a = 0.0; a <= n0; ++a)
      for (double b = 0.0; b <= n1; ++b) {
        if (a + b == 0.0) continue;
        divide(a, b);
        const double probability = std::exp(log_binomial(n0, a) + log_binomial(n1, b) - log_binomial(n, a + b)) / n;
        second += probability * problem.squared_over(divided.data());
      }
    const auto moments = gmis::exact_moments(Scheme::N2, gmis::SampleAllocation<double>(counts), problem);
    CHECK(moments.mean == Approx(1.0).epsilon(1e-11));
    CHECK(moments.variance == Approx((second - 1.0) / n).epsilon(1e-8));
  }
  for (const Counts& counts : {Counts{882, 882}, Counts{1080, 120}, Counts{1199, 1}, Counts{4, 3}}) {
    CAPTURE(counts);
    const double n = counts[0] + counts[1], alpha = counts[0] / n;
    double variance = 0.0;
    for (double a = 0.0; a <= n; ++a) {
      divide(a, n - a);
      const double probability = std::exp(log_binomial(n, a) + a * std::log(alpha) + (n - a) * std::log(1.0 - alpha));
      const double first = problem.mean_under(0, divided.data()), other = problem.mean_under(1, divided.data());
      variance += probability *
                  (problem.squared_over(divided.data()) / n - (a * first * first + (n - a) * other * other) / (n * n));
    }
    const auto moments = gmis::exact_moments(Scheme::R2, gmis::SampleAllocation<double>(counts), problem);
    CHECK(moments.mean == Approx(1.0).epsilon(1e-11));
    CHECK(moments.variance == Approx(variance).epsilon(1e-8));
  }
  // A proposal that R2 never draws, before others and after them.
  for (const auto& weights : {std::vector{0.0, 1.0}, std::vector{1.0, 0.0}}) {
    const std::size_t drawn = weights[0] > 0.0 ? 0 : 1;
    const gmis::TabulatedProblem alone(
        [](double x) {
          return test::Normal{0.0, 1.0}.pdf(x);
        },
        std::array{normals[drawn]}, nodes);
    const auto moments = gmis::exact_moments(Scheme::R2, gmis::SampleAllocation<double>(weights, 40), problem);
    CHECK(moments.mean == Approx(1.0).epsilon(1e-11));
    CHECK(moments.variance == Approx(gmis::exact_variance(Scheme::N3, alone) / 40.0).epsilon(1e-10));
  }
}
