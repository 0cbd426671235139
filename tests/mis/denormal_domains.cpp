#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/methods.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// Densities that pass through denormal numbers to zero, on domains as wide as the documents use:
// variances are numbers, and those of long double.

namespace {

using gmis::Scheme;

double parabola(double x) {
  return std::max(0.0, 1.0 - x * x);
}

/// Nodes on [−40, 40], the ends of the first program, cut where the parabola has its corners.
std::vector<gmis::QuadratureNode> wide_nodes() {
  const std::array<double, 4> breakpoints{-40.0, -1.0, 1.0, 40.0};
  return gmis::composite_gauss_legendre(breakpoints, 40);
}

/// The variances of a round of two proposals, with densities that do not underflow: in long double,
/// written out for N = 2.
struct Reference {
  long double r1 = 0, r3 = 0, n3 = 0, r2 = 0, n2 = 0;
};
Reference reference(const std::array<test::Normal, 2>& normals, double (*f)(double),
                    const std::vector<gmis::QuadratureNode>& nodes) {
  const auto density = [&](std::size_t k, long double x) {
    const auto sd = static_cast<long double>(normals[k].sd);
    const long double z = (x - static_cast<long double>(normals[k].mean)) / sd;
    return std::exp(-z * z / 2) / (sd * std::sqrt(2 * 3.14159265358979323846264338327950288L));
  };
  long double integral = 0, own[2] = {}, mixed = 0, part[2] = {};
  for (const gmis::QuadratureNode& node : nodes) {
    const long double x = static_cast<long double>(node.x);
    const long double value = static_cast<long double>(f(node.x)), weight = static_cast<long double>(node.weight);
    if (value == 0) continue;
    const long double q[2] = {density(0, x), density(1, x)};
    const long double psi = (q[0] + q[1]) / 2;
    integral += weight * value;
    for (int k = 0; k < 2; ++k) {
      own[k] += weight * value * value / q[k];
      part[k] += weight * value * q[k] / psi;
    }
    mixed += weight * value * value / psi;
  }
  const long double square = integral * integral;
  const long double each = (own[0] + own[1]) / 4 - square / 2;
  const long double all = mixed / 2 - (part[0] * part[0] + part[1] * part[1]) / 4;
  Reference variance;
  variance.r1 = each;
  variance.r3 = mixed / 2 - square / 2;
  variance.n3 = all;
  // N2: half of the second moment is that of q_j alone, half that of the mixture.
  variance.n2 = ((own[0] + own[1]) / 2 + mixed) / 4 - square / 2;
  // R2: one of the four draws each is (0, 0), (1, 1); two are the mixture. Its conditional means
  // vary with the draw.
  variance.r2 = ((own[0] - square) / 2 + (own[1] - square) / 2) / 4 + all / 2;
  return variance;
}

long double of(const Reference& reference, Scheme scheme) {
  switch (scheme) {
    case Scheme::R1:
    case Scheme::N1:
      return reference.r1;
    case Scheme::R2:
      return reference.r2;
    case Scheme::R3:
      return reference.r3;
    case Scheme::N2:
      return reference.n2;
    case Scheme::N3:
      break;
  }
  return reference.n3;
}

}  // namespace

TEST_CASE("variances are numbers on domains where densities are denormal", "[mis]") {
  const std::array<test::Normal, 2> normals{{{0.0, 0.5}, {0.0, 5.0}}};
  const auto nodes = wide_nodes();
  bool meets_denormal = false;
  for (const auto& node : nodes)
    meets_denormal = meets_denormal || std::fpclassify(normals[0].pdf(node.x)) == FP_SUBNORMAL;
  REQUIRE(meets_denormal);
  const gmis::TabulatedProblem table(parabola, normals, nodes);
  const Reference expected = reference(normals, parabola, nodes);
  for (const Scheme scheme : gmis::all_schemes) {
    CAPTURE(name_of(scheme));
    const auto moments = exact_moments(scheme, table);
    CHECK(std::isfinite(moments.variance));
    CHECK(moments.variance == Approx(static_cast<double>(of(expected, scheme))).epsilon(1e-9));
    CHECK(moments.mean == Approx(4.0 / 3.0).epsilon(1e-9));
  }
  CHECK(exact_moments(gmis::Groups<>(2, 1), table).variance == Approx(static_cast<double>(expected.r1)).epsilon(1e-9));
  CHECK(exact_moments(gmis::Groups<>(2, 2), table).variance == Approx(static_cast<double>(expected.n3)).epsilon(1e-9));
  gmis::Philox source(gmis_test::seed(3));
  for (const Scheme scheme : {Scheme::R2, Scheme::N2})
    CHECK(std::isfinite(averaged_variance(scheme, table, 20, source).value));
}

// f²/q beyond the range of double where q is denormal and f is not zero: infinite, not NaN and not
// small.
TEST_CASE("a variance beyond the range of double is infinite", "[mis]") {
  const std::array<test::Normal, 2> normals{{{0.0, 1.0}, {0.5, 1.0}}};
  const auto flat = [](double x) { return std::abs(x) < 38.4 ? 1.0 : 0.0; };
  const auto nodes = wide_nodes();
  const gmis::TabulatedProblem table(flat, normals, nodes);
  for (const Scheme scheme : gmis::all_schemes) {
    if (scheme == Scheme::N2 && !table.has_full_support()) continue;
    CAPTURE(name_of(scheme));
    const auto moments = exact_moments(scheme, table);
    CHECK_FALSE(std::isfinite(moments.variance));
    CHECK(moments.variance == std::numeric_limits<double>::infinity());
  }
  gmis::Philox source(1);
  CHECK_THROWS_AS(gmis::best_scheme(table, gmis::CostModel{1.0, 1.0}, source), std::invalid_argument);
}

TEST_CASE("best_scheme is not misled where f is zero and a density denormal", "[mis]") {
  const std::array<test::Normal, 2> normals{{{0.0, 0.1}, {0.0, 5.0}}};
  const auto nodes = wide_nodes();
  const gmis::TabulatedProblem exact(parabola, normals, nodes);
  const gmis::CostModel costs{1.0, 1.0};
  gmis::Philox source(gmis_test::seed(1));
  const auto truth = gmis::best_scheme(exact, costs, source);
  CHECK(truth.chosen().scheme == Scheme::N3);
  for (int trial = 0; trial < 123; ++trial) {
    const gmis::PilotSamples pilot(parabola, normals, 200, source);
    const auto choice = gmis::best_scheme(pilot.problem(), costs, source);
    for (const auto& candidate : choice.candidates) CHECK(std::isfinite(candidate.variance));
    CHECK(exact.integral() == Approx(4.0 / 3.0));
    const Scheme scheme = choice.chosen().scheme;
    CHECK((scheme == Scheme::N3 || scheme == Scheme::R3));
  }
}

TEST_CASE("groups are tried in the sizes that they really have, once each", "[mis]") {
  using Sizes = std::vector<std::size_t>;
  CHECK(gmis::group_sizes_to_try(2) == Sizes{});
  CHECK(gmis::group_sizes_to_try(3) == Sizes{2});
  CHECK(gmis::group_sizes_to_try(4) == Sizes{2});  // groups of 3 of 4 are two groups of 2
  CHECK(gmis::group_sizes_to_try(8) == Sizes{2, 3, 4});
  CHECK(gmis::group_sizes_to_try(64) == Sizes{2, 3, 4, 6, 8, 11, 16, 22, 32});
  for (std::size_t n = 2; n < 200; ++n) {
    std::size_t previous = 0;
    for (const std::size_t size : gmis::group_sizes_to_try(n)) {
      const gmis::Groups<> groups(n, size);
      std::size_t largest = 0;
      for (std::size_t g = 0; g < groups.size(); ++g) largest = std::max(largest, groups.members(g).size());
      CHECK(largest == size);
      CHECK(size > previous);
      previous = size;
    }
  }
}

// A node 38 standard deviations out: q is denormal, and a fraction of it rounds to 0.
TEST_CASE("counts have variances where a fraction of a density underflows", "[mis]") {
  const std::array<test::Normal, 2> normals{{{0.0, 1.0}, {-1.0, 1.0}}};
  const std::vector<std::uint32_t> counts{1, 3};
  auto nodes = wide_nodes();
  nodes.push_back({38.565, 0.01});
  bool meets_underflow = false;
  for (const auto& node : nodes)
    meets_underflow = meets_underflow || (normals[0].pdf(node.x) > 0.0 && 0.25 * normals[0].pdf(node.x) == 0.0);
  REQUIRE(meets_underflow);
  const gmis::TabulatedProblem table(parabola, normals, nodes);
  // In long double, whose range no density leaves.
  long double second = 0, part[2] = {};
  for (const auto& node : nodes) {
    const long double value = static_cast<long double>(parabola(node.x)),
                      weight = static_cast<long double>(node.weight);
    if (value == 0) continue;
    const long double q[2] = {static_cast<long double>(normals[0].pdf(node.x)),
                              static_cast<long double>(normals[1].pdf(node.x))};
    const long double psi = (q[0] + 3 * q[1]) / 4;
    second += weight * value * value / psi;
    for (int k = 0; k < 2; ++k) part[k] += weight * value * q[k] / psi;
  }
  const auto expected = static_cast<double>(second / 4 - (part[0] * part[0] + 3 * part[1] * part[1]) / 16);
  const auto moments = gmis::exact_moments(counts, table);
  CHECK(moments.mean == Approx(4.0 / 3.0).epsilon(1e-9));
  CHECK(moments.variance == Approx(expected).epsilon(1e-9));
  const std::vector<double> none{0.0, 0.0}, some{0.5, 0.25};
  CHECK(gmis::exact_moments_controlled(counts, none, table).variance == Approx(expected).epsilon(1e-9));
  CHECK(std::isfinite(gmis::exact_moments_controlled(counts, some, table).variance));
  CHECK(gmis::exact_moments_controlled(counts, some, table).mean == Approx(4.0 / 3.0).epsilon(1e-9));
  CHECK(gmis::exact_moments_with_weights(gmis::RatioWeights<gmis::Balance>{}, counts, table).variance ==
        Approx(expected).epsilon(1e-9));
  CHECK(gmis::optimal_counts(table, 4).size() == 2);
}

TEST_CASE("a variance of counts beyond the range of double is infinite", "[mis]") {
  const std::array<test::Normal, 2> normals{{{0.0, 1.0}, {0.5, 1.0}}};
  const auto flat = [](double x) { return std::abs(x) < 38.4 ? 1.0 : 0.0; };
  const gmis::TabulatedProblem table(flat, normals, wide_nodes());
  const std::vector<std::uint32_t> counts{1, 3};
  const auto moments = gmis::exact_moments(counts, table);
  CHECK(moments.variance == std::numeric_limits<double>::infinity());
  CHECK(std::isfinite(moments.mean));
  CHECK(gmis::exact_moments_of_mixture(std::vector<double>{0.25, 0.75}, 4, table).variance ==
        std::numeric_limits<double>::infinity());
}
