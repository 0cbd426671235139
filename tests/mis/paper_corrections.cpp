#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/oracle_cases.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// What the paper prints wrongly about MIS estimators (docs/paper-corrections.md): every printed
// form is computed here and shown to fail where the corrected one holds. The decisive problem is
// N = 2 with bounded weights, so that a measured variance tells the forms apart.

namespace {

using gmis::Scheme;

const std::array<test::Bump, 2> bumps{{{0.0, 0.5, 0.3}, {0.5, 1.0, 0.3}}};
double integrand(double x) {
  return x < 0.5 ? 5.0 + x : 0.2;
}

std::vector<gmis::QuadratureNode> nodes() {
  const std::array<double, 3> breakpoints{0.0, 0.5, 1.0};
  return gmis::composite_gauss_legendre(breakpoints, 1);
}

template <class G>
double integrate(const std::vector<gmis::QuadratureNode>& rule, G g) {
  double sum = 0.0;
  for (const auto& node : rule) sum += node.weight * g(node.x);
  return sum;
}

/// The figures that the printed formulas are made of, for N = 2.
struct TwoProposals {
  double integral;                   // I
  double second_moment_psi;          // ∫ f²/ψ
  double mean_second_moment_own;     // (1/2) Σ_k ∫ f²/q_k
  double mean_squared_mean_under_q;  // (1/2) Σ_k (∫ f q_k/ψ)²
};

template <class F, class P>
TwoProposals figures(F f, const P& q, const std::vector<gmis::QuadratureNode>& rule) {
  const auto psi = [&](double x) { return 0.5 * (q[0].pdf(x) + q[1].pdf(x)); };
  TwoProposals result{};
  result.integral = integrate(rule, f);
  result.second_moment_psi = integrate(rule, [&](double x) { return f(x) * f(x) / psi(x); });
  for (const auto& own : q) {
    const double mean = integrate(rule, [&](double x) { return f(x) * own.pdf(x) / psi(x); });
    result.mean_second_moment_own += 0.5 * integrate(rule, [&](double x) { return f(x) * f(x) / own.pdf(x); });
    result.mean_squared_mean_under_q += 0.5 * mean * mean;
  }
  return result;
}

/// Var(N2) as printed: (1/N²) Σ_n (E ∫ f²/p_n − E[m_n²]), m_n = ∫ f q_{j_n}/p_n. The first draw has
/// p = ψ, the second p = q_j and m = I.
double printed_n2(const TwoProposals& t) {
  return 0.25 * (t.second_moment_psi + t.mean_second_moment_own) -
         0.25 * (t.mean_squared_mean_under_q + t.integral * t.integral);
}
double corrected_n2(const TwoProposals& t) {
  return 0.25 * (t.second_moment_psi + t.mean_second_moment_own) - 0.5 * t.integral * t.integral;
}

/// Measured variance of single rounds; false-alarm rate 1e-5 each.
test::Interval measured(Scheme scheme) {
  gmis::Philox source(gmis_test::seed(31));
  std::vector<double> rounds(80000);
  for (double& value : rounds) value = gmis::estimate(scheme, integrand, bumps, 1, source).mean;
  return test::bootstrap_variance_interval(rounds, 1e-5, source);
}

}  // namespace

TEST_CASE("Var(N2): N I² is subtracted, not the printed sum of E[m_n²]", "[mis][paper]") {
  const auto t = figures(integrand, bumps, nodes());
  const auto interval = measured(Scheme::N2);
  CAPTURE(interval.low, interval.high, corrected_n2(t), printed_n2(t));
  CHECK(interval.contains(corrected_n2(t)));
  CHECK_FALSE(interval.contains(printed_n2(t)));
  CHECK(gmis::exact_variance(Scheme::N2, {integrand, bumps, nodes()}) == Approx(corrected_n2(t)).epsilon(1e-12));

  // Case D: 2.97763 where the printed form gives 2.96171.
  const auto d = figures(test::integrand_d, test::proposals_d, test::oracle_nodes(64));
  CHECK(corrected_n2(d) == Approx(2.97763).epsilon(2e-6));
  CHECK(printed_n2(d) == Approx(2.96171).epsilon(2e-6));
}

TEST_CASE("Var(R2) is not Var(N2)", "[mis][paper]") {
  const auto t = figures(integrand, bumps, nodes());
  const gmis::TabulatedProblem problem(integrand, bumps, nodes());
  const double r2 = gmis::exact_variance(Scheme::R2, problem);
  const double n2 = gmis::exact_variance(Scheme::N2, problem);
  CHECK(n2 - r2 == Approx((t.mean_squared_mean_under_q - t.integral * t.integral) / 4.0).epsilon(1e-10));
  const auto interval = measured(Scheme::R2);
  CAPTURE(interval.low, interval.high, r2, n2);
  CHECK(interval.contains(r2));
  CHECK_FALSE(interval.contains(n2));
  // Case B (N = 3): 0.886525 and 2.27007.
  const auto b = test::case_b();
  CHECK(gmis::exact_variance(Scheme::N2, b) > 2.5 * gmis::exact_variance(Scheme::R2, b));
}

TEST_CASE("Var(R3) and Var(N3) are one integral, with no sum over k before it", "[mis][paper]") {
  const auto t = figures(integrand, bumps, nodes());
  const double n = 2.0;
  const double r3 = t.second_moment_psi / n - t.integral * t.integral / n;
  const double printed_r3 = n * t.second_moment_psi / n - t.integral * t.integral / n;
  const double n3 = t.second_moment_psi / n - t.mean_squared_mean_under_q / n;
  const double printed_n3 = n * t.second_moment_psi / n - t.mean_squared_mean_under_q / n;
  const auto interval_r3 = measured(Scheme::R3), interval_n3 = measured(Scheme::N3);
  CHECK(interval_r3.contains(r3));
  CHECK_FALSE(interval_r3.contains(printed_r3));
  CHECK(interval_n3.contains(n3));
  CHECK_FALSE(interval_n3.contains(printed_n3));
  CHECK(gmis::exact_variance(Scheme::R3, {integrand, bumps, nodes()}) == Approx(r3).epsilon(1e-12));
  CHECK(gmis::exact_variance(Scheme::N3, {integrand, bumps, nodes()}) == Approx(n3).epsilon(1e-12));
}

// The multi-sample estimator Σ_i (1/n_i) Σ_k w_i(x_{i,k}) f(x_{i,k}) / p(x_{i,k}): with p_i it is
// unbiased for any weights that sum to one; with one and the same p for all techniques, be it the
// mixture or any of them, it is not.
TEST_CASE("the MIS estimator divides by p_i(x_{i,k}), not by one p", "[mis][paper]") {
  const auto rule = nodes();
  const double integral = integrate(rule, integrand);
  const auto psi = [](double x) { return 0.5 * (bumps[0].pdf(x) + bumps[1].pdf(x)); };
  const auto balance = [&](std::size_t i, double x) { return bumps[i].pdf(x) / (2.0 * psi(x)); };
  const auto expectation = [&](auto divisor) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 2; ++i)
      sum += integrate(rule, [&](double x) { return bumps[i].pdf(x) * balance(i, x) * integrand(x) / divisor(i, x); });
    return sum;
  };
  CHECK(expectation([&](std::size_t i, double x) { return bumps[i].pdf(x); }) == Approx(integral).epsilon(1e-12));
  CHECK(std::abs(expectation([&](std::size_t, double x) { return psi(x); }) / integral - 1.0) > 0.02);
  CHECK(std::abs(expectation([&](std::size_t, double x) { return bumps[0].pdf(x); }) / integral - 1.0) > 0.02);
  CHECK(std::abs(expectation([&](std::size_t, double x) { return bumps[1].pdf(x); }) / integral - 1.0) > 0.02);

  // And the library's multi-sample form is the one with p_i.
  gmis::Philox source(gmis_test::seed(6));
  const auto estimate = gmis::estimate_weighted(gmis::Balance{}, integrand, bumps, 20000, source,
                                                gmis::SampleAllocation<double>(std::array<std::uint32_t, 2>{1, 1}));
  CHECK(test::normal_p_value((estimate.mean - integral) / estimate.standard_error.value()) > 1e-4);
}

TEST_CASE("S3 takes each index once a round: it is without replacement", "[mis][paper]") {
  gmis::Philox source(gmis_test::seed(2));
  const std::array<test::Ramp, 5> ramps{};
  bool repeated_under_s1 = false;
  for (int round = 0; round < 20; ++round) {
    std::multiset<std::size_t> deterministic, random;
    gmis::sample_round<Scheme::N3>(ramps, source, [&](double, double, std::size_t k) { deterministic.insert(k); });
    gmis::sample_round<Scheme::R3>(ramps, source, [&](double, double, std::size_t k) { random.insert(k); });
    CHECK(deterministic == std::multiset<std::size_t>{0, 1, 2, 3, 4});
    repeated_under_s1 = repeated_under_s1 || std::set(random.begin(), random.end()).size() < 5;
  }
  CHECK(repeated_under_s1);
  // Were it with replacement, the variance with ψ would be that of R3; it is smaller.
  CHECK_FALSE(measured(Scheme::N3).contains(gmis::exact_variance(Scheme::R3, {integrand, bumps, nodes()})));
}

// ω_n is introduced as f/p; W1–W5 then print the density itself for it. Read literally, the mean of
// ω_n under W5 would be that of ψ(x_n), whose expectation is ∫ ψ² whatever f is. φ_n is the
// denominator, f/φ_n the weight.
TEST_CASE("W1-W5 define the denominator, not the weight", "[mis][paper]") {
  const auto rule = nodes();
  const double integral = integrate(rule, integrand);
  const auto psi = [](double x) { return 0.5 * (bumps[0].pdf(x) + bumps[1].pdf(x)); };
  const double printed_expectation = integrate(rule, [&](double x) { return psi(x) * psi(x); });
  gmis::Philox source(gmis_test::seed(12));
  std::vector<double> as_weight, as_denominator;
  for (int round = 0; round < 4000; ++round) {
    double weights = 0.0, ratios = 0.0;
    gmis::sample_round<Scheme::N3>(bumps, source, [&](double x, double phi, std::size_t) {
      weights += phi / 2.0;
      ratios += integrand(x) / phi / 2.0;
    });
    as_weight.push_back(weights);
    as_denominator.push_back(ratios);
  }
  CHECK(test::mean_p_value(test::moments_of(as_denominator), integral) > 1e-4);
  CHECK(test::mean_p_value(test::moments_of(as_weight), integral) < 1e-12);
  CHECK(test::mean_p_value(test::moments_of(as_weight), printed_expectation) > 1e-4);
}

TEST_CASE("512 × 512 pixels make 262,144 light paths; 589k is 768 × 768", "[mis][paper]") {
  STATIC_REQUIRE(512 * 512 == 262144);
  STATIC_REQUIRE(768 * 768 == 589824);
}
