#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

// Tabulated problems and the rules under them: against closed forms.

namespace {

using gmis::Scheme;

/// 1/(π s (1 + ((x − c)/s)²)).
struct Cauchy {
  double centre, scale;
  double sample(gmis::UniformSource auto& source) const {
    return centre + scale * std::tan(std::numbers::pi * (gmis::uniform<double>(source) - 0.5));
  }
  double pdf(double x) const {
    const double z = (x - centre) / scale;
    return 1.0 / (std::numbers::pi * scale * (1.0 + z * z));
  }
};

/// The product of two normals in the plane.
struct Normal2 {
  test::Normal x, y;
  glm::dvec2 sample(gmis::UniformSource auto& source) const {
    const double first = x.sample(source);
    return {first, y.sample(source)};
  }
  double pdf(const glm::dvec2& p) const { return x.pdf(p.x) * y.pdf(p.y); }
};
struct Cube {
  glm::dvec3 sample(gmis::UniformSource auto& source) const {
    const double x = gmis::uniform<double>(source), y = gmis::uniform<double>(source);
    return {x, y, gmis::uniform<double>(source)};
  }
  double pdf(const glm::dvec3&) const { return 1.0; }
};

/// Var of f/q for f = normal(0, a²), q = normal(0, b²): b²/(a √(2 b² − a²)) − 1.
double variance_of_normals(double a, double b) {
  return b * b / (a * std::sqrt(2.0 * b * b - a * a)) - 1.0;
}

}  // namespace

TEST_CASE("a rule over the line integrates heavy tails and light ones", "[mis]") {
  const auto nodes = gmis::gauss_legendre_over_line(0.3, 1.5, 32);
  const auto integrate = [&](auto f) {
    double sum = 0.0;
    for (const auto& node : nodes) sum += node.weight * f(node.x);
    return sum;
  };
  CHECK(integrate([](double x) { return Cauchy{0.3, 2.0}.pdf(x); }) == Approx(1.0).epsilon(1e-12));
  CHECK(integrate([](double x) { return test::Normal{1.0, 0.5}.pdf(x); }) == Approx(1.0).epsilon(1e-12));
  CHECK(integrate([](double x) { return x * x * test::Normal{0.0, 2.0}.pdf(x); }) == Approx(4.0).epsilon(1e-12));
  // ∫ p²/q for Cauchy densities of widths 1 and s: (s + 1/s)/2.
  const std::array<Cauchy, 1> wide{{{0.3, 1.5}}};
  const gmis::TabulatedProblem problem([](double x) { return Cauchy{0.3, 1.0}.pdf(x); }, wide, nodes);
  CHECK(gmis::exact_variance(Scheme::N3, problem) == Approx((1.5 + 1.0 / 1.5) / 2.0 - 1.0).epsilon(1e-12));

  const std::array<double, 2> jumps{-0.25, 1.25};
  const auto cut = gmis::gauss_legendre_over_line(0.0, 1.0, 4, jumps);
  double box = 0.0;
  for (const auto& node : cut) box += node.x > -0.25 && node.x < 1.25 ? node.weight : 0.0;
  CHECK(box == Approx(1.5).epsilon(1e-12));
  CHECK_THROWS_AS(gmis::gauss_legendre_over_line(0.0, 0.0, 4), std::invalid_argument);
}

TEST_CASE("tensor rules: exact variances in the plane and in space", "[mis]") {
  const auto line = gmis::gauss_legendre_over_line(0.0, 1.0, 12);
  const auto plane = gmis::tensor_rule(line, line);
  const std::array<Normal2, 1> proposal{{{{0.0, 1.3}, {0.0, 1.6}}}};
  const auto f = [](const glm::dvec2& p) { return test::Normal{0.0, 1.0}.pdf(p.x) * test::Normal{0.0, 1.0}.pdf(p.y); };
  const gmis::TabulatedProblem problem(f, proposal, plane);
  const double expected = (variance_of_normals(1.0, 1.3) + 1.0) * (variance_of_normals(1.0, 1.6) + 1.0) - 1.0;
  CHECK(gmis::exact_variance(Scheme::R1, problem) == Approx(expected).epsilon(1e-9));
  const auto check =
      gmis::check_problem(f, proposal, plane, gmis::tensor_rule(line, gmis::gauss_legendre_over_line(0.0, 1.0, 16)));
  CHECK(check.passes(1e-8));

  const std::array<double, 2> ends{0.0, 1.0};
  const auto side = gmis::composite_gauss_legendre(ends, 1, 4);
  const std::array<Cube, 1> cube;
  const gmis::TabulatedProblem space([](const glm::dvec3& p) { return p.x * p.y * p.y * p.z; }, cube,
                                     gmis::tensor_rule(side, side, side));
  CHECK(space.integral() == Approx(1.0 / 12.0).epsilon(1e-12));
  CHECK(gmis::exact_variance(Scheme::N3, space) == Approx(1.0 / 45.0 - 1.0 / 144.0).epsilon(1e-12));
}

TEST_CASE("a problem of each channel", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 2);
  const std::vector<test::Ramp> ramps{{-1.0}, {1.2}};
  const auto f = [](double x) { return glm::vec3(x, x * x, 1.0F); };
  const auto channels = gmis::tabulate_channels(f, ramps, nodes);
  REQUIRE(channels.size() == 3);
  const std::array<double (*)(double), 3> each{[](double x) { return static_cast<double>(static_cast<float>(x)); },
                                               [](double x) { return static_cast<double>(static_cast<float>(x * x)); },
                                               [](double) { return 1.0; }};
  for (std::size_t c = 0; c < 3; ++c) {
    const gmis::TabulatedProblem alone(each[c], ramps, nodes);
    CHECK(gmis::exact_variance(Scheme::N3, channels[c]) == gmis::exact_variance(Scheme::N3, alone));
  }
  // A value given by its logarithm is one number.
  const gmis::TabulatedProblem logs([](double x) { return gmis::LogValue<double>{std::log(x), -1.0}; }, ramps, nodes);
  CHECK(logs.integral() == Approx(-0.5).epsilon(1e-12));
}

TEST_CASE("check_problem finds a range that cuts off and a rule with too few points", "[mis]") {
  const auto rule = [](double end, std::size_t panels) {
    const std::array<double, 2> ends{-end, end};
    return gmis::composite_gauss_legendre(ends, panels);
  };
  const std::array<test::Normal, 3> normals{{{-3.0, 2.0}, {0.0, 2.0}, {3.0, 2.0}}};
  const auto f = [](double x) { return std::exp(-0.2 * x * x) * (1.0 + 0.5 * std::sin(3.0 * x)); };

  const auto sound = gmis::check_problem(f, normals, rule(40.0, 64), rule(40.0, 128));
  CHECK(sound.passes());
  CHECK(sound.integral == Approx(3.963327).epsilon(1e-6));

  // The first program, cut at ±2: the mean is 3.15 in place of 3.96.
  const auto cut = gmis::check_problem(f, normals, rule(2.0, 64), rule(2.0, 128));
  CHECK(cut.finding() == "a density integrates to less than one: the range cuts it off, or too few nodes");
  // Four nodes.
  const auto four = gmis::check_problem(f, normals, rule(40.0, 1), rule(40.0, 2));
  CHECK_FALSE(four.passes());
  // Cauchy proposals on ±60: what is cut off is a hundredth of each.
  const std::array<Cauchy, 2> cauchys{{{-1.0, 1.0}, {1.0, 1.0}}};
  const auto g = [](double x) { return 0.5 * (Cauchy{-1.0, 1.0}.pdf(x) + Cauchy{1.0, 1.2}.pdf(x)); };
  CHECK_FALSE(gmis::check_problem(g, cauchys, rule(60.0, 64), rule(60.0, 128)).passes());
  CHECK(gmis::check_problem(g, cauchys, gmis::gauss_legendre_over_line(0.0, 1.0, 16),
                            gmis::gauss_legendre_over_line(0.0, 1.0, 32))
            .passes());
  // A Cauchy integrand with normal proposals: every density is whole, and f goes on where the range
  // ends.
  const auto heavy = gmis::check_problem(g, normals, rule(60.0, 64), rule(60.0, 128));
  CHECK(heavy.end_share > 1e-6);
  CHECK_FALSE(heavy.passes());
  // A density on a bounded range is not cut off by it; nor is one whose samples may fail.
  const std::array<double, 2> unit{0.0, 1.0};
  const std::array<test::Ramp, 2> ramps{{{-1.0}, {1.0}}};
  CHECK(gmis::check_problem([](double x) { return 1.0 + x; }, ramps, gmis::composite_gauss_legendre(unit, 2),
                            gmis::composite_gauss_legendre(unit, 4))
            .passes());
  struct Half {
    std::optional<double> sample(gmis::Philox& source) const {
      const double x = 2.0 * gmis::uniform<double>(source);
      return x < 1.0 ? std::optional<double>(x) : std::nullopt;
    }
    double pdf(double) const { return 0.5; }
  };
  const std::array<Half, 1> halves;
  CHECK(gmis::check_problem([](double x) { return x; }, halves, gmis::composite_gauss_legendre(unit, 2),
                            gmis::composite_gauss_legendre(unit, 4))
            .passes());
  // Other findings: a density that is none, a jump inside a panel, f beside all proposals.
  const auto finding = [](auto f_of_x, const auto& proposals, std::span<const double> ends) {
    return std::string(gmis::check_problem(f_of_x, proposals, gmis::composite_gauss_legendre(ends, 2),
                                           gmis::composite_gauss_legendre(ends, 4))
                           .finding());
  };
  const std::array<test::FaultyDensity, 1> doubled{{{3.0}}};  // 1 below one half, 3 above
  const std::array<test::Uniform, 1> whole{}, inner{{{0.25, 0.75}}};
  const std::array<double, 4> cuts{0.0, 0.25, 0.75, 1.0};
  const auto one = [](double) { return 1.0; };
  CHECK(finding(one, doubled, unit) == "a density integrates to more than one: too few nodes, or no density");
  CHECK(finding([](double x) { return x < 0.3 ? 1.0 : 0.0; }, whole, unit) ==
        "the finer rule has another integral: too few nodes, or an infinite one");
  CHECK(finding(one, inner, cuts) ==
        "the integrand has mass at the ends of the range, where the proposals have none: the range cuts it off");
}

TEST_CASE("a problem with a node weight that is not a number is refused", "[mis]") {
  const std::array<double, 2> ends{0.0, 1.0};
  auto nodes = gmis::composite_gauss_legendre(ends, 1);
  const std::array<test::Ramp, 1> ramps{{{1.0}}};
  const auto f = [](double x) { return x; };
  CHECK_NOTHROW(gmis::TabulatedProblem(f, ramps, nodes));
  nodes[3].weight = std::nan("");
  const std::string expected = "the integrand, or a weight, is not finite at a quadrature node";
  CHECK(gmis_test::message_of([&] { return gmis::TabulatedProblem(f, ramps, nodes); }).find(expected) !=
        std::string::npos);
  CHECK(gmis_test::message_of([&] { return gmis::tabulate_channels(f, ramps, nodes); }).find(expected) !=
        std::string::npos);
}
