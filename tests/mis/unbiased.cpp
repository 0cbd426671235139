#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <tuple>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// All fifteen pairs, k ∈ {1, 2, 3} rounds, on integrands whose integral is known in closed form and
// which every proposal covers. One z-test on the mean of independent estimates each; 9 problems ×
// 45 tests, false-alarm rate 1e-4 in all.

namespace {

constexpr std::size_t problem_count = 9;
constexpr double family_rate = 1e-4;

/// A proposal that throws away the samples it draws outside [0, 1): its density integrates to less
/// than one.
struct Truncated {
  test::Normal normal;
  std::optional<double> sample(gmis::UniformSource auto& source) const {
    const double x = normal.sample(source);
    return x >= 0.0 && x < 1.0 ? std::optional<double>(x) : std::nullopt;
  }
  double pdf(double x) const { return x >= 0.0 && x < 1.0 ? normal.pdf(x) : 0.0; }
};

template <class Integrand, class P>
void check_unbiased(const P& proposals, Integrand f, double truth, std::size_t samples = 4000) {
  const double level = test::sidak_level(family_rate, problem_count * 45);
  std::uint64_t seed = 0;
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings)
      for (const std::uint64_t rounds : {1U, 2U, 3U}) {
        CAPTURE(name_of(selection), name_of(weighting), rounds);
        gmis::Philox source(gmis_test::seed(++seed));
        std::vector<double> means(samples / rounds);
        for (double& mean : means) mean = gmis::estimate(selection, weighting, f, proposals, rounds, source).mean;
        const auto moments = test::moments_of(means);
        CAPTURE(moments.mean, moments.standard_error, truth);
        CHECK(test::mean_p_value(moments, truth) > level);
        // So that the test means something: it would see a bias of 10 %.
        CHECK(moments.standard_error * 5.0 < 0.1 * std::max(std::abs(truth), 1.0));
      }
}

const std::array<test::Ramp, 3> ramps{{{-1.4}, {0.0}, {1.4}}};

}  // namespace

TEST_CASE("unbiased: smooth", "[mis]") {
  check_unbiased(
      ramps, [](double x) { return 0.5 * test::pi * std::sin(test::pi * x); }, 1.0);
}

TEST_CASE("unbiased: multimodal", "[mis]") {
  const auto f = [](double x) {
    double sum = 0.0;
    for (const double centre : {0.2, 0.5, 0.8}) {
      const double distance = std::abs(x - centre);
      sum += distance < 0.1 ? 0.1 - distance : 0.0;  // a tent of area 0.01
    }
    return sum / 0.03;
  };
  const std::vector<test::Bump> bumps{{0.1, 0.3, 0.4}, {0.4, 0.6, 0.4}, {0.7, 0.9, 0.4}};
  check_unbiased(bumps, f, 1.0, 8000);
}

TEST_CASE("unbiased: discontinuous", "[mis]") {
  check_unbiased(
      std::make_tuple(test::Uniform{}, test::Bump{0.25, 0.75, 0.5}, test::Ramp{1.0}),
      [](double x) { return x > 0.25 && x < 0.7 ? 2.0
                            : x > 0.9           ? 1.0
                                                : 0.0; }, 0.9 + 0.1);
}

TEST_CASE("unbiased: sign-changing", "[mis]") {
  // Positive and negative parts nearly cancel: ∫ cos(3πx) + 0.2 = 0.2.
  check_unbiased(
      ramps, [](double x) { return std::cos(3.0 * test::pi * x) + 0.2; }, 0.2);
}

TEST_CASE("unbiased: singular but integrable", "[mis]") {
  check_unbiased(
      std::make_tuple(test::Uniform{}, test::Bump{0.0, 0.1, 0.5}), [](double x) { return std::pow(x, -0.2); }, 1.25);
}

TEST_CASE("unbiased: three dimensions, densities as logarithms", "[mis]") {
  const std::array<test::Normal3, 2> proposals{{{{0.5, 0.0, 0.0}, 1.2}, {{-0.5, 0.2, 0.0}, 1.4}}};
  const test::Normal3 target{{0.0, 0.0, 0.0}, 1.0};
  check_unbiased(
      proposals, [&](const glm::dvec3& x) { return std::exp(target.log_pdf(x)); }, 1.0);
}

TEST_CASE("unbiased: directions in float", "[mis]") {
  const std::array<test::TiltedSphere, 3> proposals{{{0.0F}, {0.5F}, {0.8F}}};
  // ∫ (1 + z²) over the sphere is 4π (1 + 1/3).
  check_unbiased(
      proposals, [](const glm::vec3& w) { return (1.0F + w.z * w.z) * 3.0F / (16.0F * float(test::pi)); }, 1.0);
}

TEST_CASE("unbiased: proposals that can fail", "[mis]") {
  const std::array<Truncated, 2> proposals{{{{0.3, 0.5}}, {{0.9, 0.6}}}};
  check_unbiased(
      proposals, [](double x) { return 2.0 * x; }, 1.0);
}

TEST_CASE("unbiased: very unequal proposals", "[mis]") {
  // Steep enough for the schemes to differ, with weights that stay bounded.
  const std::vector<test::Bump> bumps{{0.0, 0.1, 0.3}, {0.1, 0.9, 0.3}, {0.9, 1.0, 0.3}, {0.0, 1.0, 1.0}};
  check_unbiased(
      bumps, [](double x) { return 3.0 * x * x; }, 1.0, 8000);
}
