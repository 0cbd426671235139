#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/testing.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The variance of single rounds, measured, against the one by quadrature. 6 schemes × N ∈ {1, 2, 4,
// 8}; a false-alarm rate of 1e-3 for the family (weights are bounded, so the normal approximation
// serves).
TEST_CASE("measured variances are the exact ones", "[mis]") {
  const std::size_t n = GENERATE(1U, 2U, 4U, 8U);
  CAPTURE(n);
  std::vector<test::Bump> bumps;
  std::vector<double> breakpoints{0.0};
  for (std::size_t k = 0; k < n; ++k) {
    const double low = static_cast<double>(k) / static_cast<double>(n);
    const double high = static_cast<double>(k + 1) / static_cast<double>(n);
    bumps.push_back({low, high, 0.25});
    breakpoints.push_back(high);
  }
  const auto f = [](double x) { return std::exp(2.0 * x) * (1.0 + std::sin(7.0 * x)); };
  const gmis::TabulatedProblem problem(f, bumps, gmis::composite_gauss_legendre(breakpoints, 1));
  const double level = test::sidak_level(1e-3, 24);

  for (const gmis::Scheme scheme : gmis::all_schemes) {
    CAPTURE(name_of(scheme));
    gmis::Philox source(gmis_test::seed(21), static_cast<std::uint32_t>(n));
    const double exact = gmis::exact_variance(scheme, problem);
    const auto check = gmis::check_estimator([&] { return gmis::estimate(scheme, f, bumps, 1, source).mean; },
                                             gmis::exact_moments(scheme, problem), 30000, level);
    INFO(check.text());
    CHECK(check.passes());
    CHECK(check.smallest_variance_error < 0.2);  // narrow enough to tell one scheme from another

    // k rounds in one estimate report the same variance of one round.
    const auto together = gmis::estimate(scheme, f, bumps, 30000, source);
    CHECK(together.variance.value() == Approx(exact).epsilon(0.15));
    CHECK(together.standard_error.value() == Approx(std::sqrt(exact / 30000.0)).epsilon(0.08));
  }
}
