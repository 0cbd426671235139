#include <array>
#include <cmath>
#include <gmis/mis/diagnostics.hpp>
#include <gmis/testing/catch.hpp>
#include <numbers>
#include <vector>

// The code of docs/test-your-estimator.md: an estimator written as one would without the library,
// and its test.

namespace {

struct Normal {
  double mean, deviation;
  double sample(gmis::UniformSource auto& source) const {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - gmis::uniform<double>(source)));
    return mean + deviation * radius * std::cos(2.0 * std::numbers::pi * gmis::uniform<double>(source));
  }
  double pdf(double x) const {
    const double z = (x - mean) / deviation;
    return std::exp(-0.5 * z * z) / (deviation * std::sqrt(2.0 * std::numbers::pi));
  }
};

double f(double x) {
  return std::exp(-x * x / 7.0);
}

struct MyEstimator {
  std::array<Normal, 2> proposals{{{-1.5, 2.0}, {1.0, 1.5}}};
  std::array<double, 2> counts{3.0, 1.0};
  std::array<double, 2> counts_in_weight = counts;    // planted bug: {1, 1}
  std::array<Normal, 2> samplers = proposals;         // planted bug: a deviation that is 2 % too large
  std::array<double, 2> counts_in_division = counts;  // planted bug: {1, 1}
  double lost = 1e9;                                  // planted bug: samples beyond it count as zero

  double round(gmis::UniformSource auto& source) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      for (int i = 0; i < static_cast<int>(counts[k]); ++i) {
        const double x = samplers[k].sample(source);
        const double q[2] = {proposals[0].pdf(x), proposals[1].pdf(x)};
        const double all = counts_in_weight[0] * q[0] + counts_in_weight[1] * q[1];
        const double weight = counts_in_weight[k] * q[k] / all;
        if (x < lost) sum += weight * f(x) / (counts_in_division[k] * q[k]);
      }
    return sum;
  }
};

}  // namespace

TEST_CASE("my estimator has the mean and the variance that it should have") {
  const MyEstimator mine;
  const std::vector<std::uint32_t> counts{3, 1};
  const auto nodes = gmis::gauss_legendre_over_line(0.0, 2.0, 32);
  const gmis::TabulatedProblem problem(f, mine.proposals, nodes);

  gmis::Philox source = gmis::seeded("my estimator");
  const gmis::EstimatesExactly has_exact_moments(gmis::exact_moments(counts, problem), 400'000);
  REQUIRE_THAT([&] { return mine.round(source); }, has_exact_moments);
}

namespace {

gmis::EstimatorCheck check(const MyEstimator& mine) {
  const std::vector<std::uint32_t> counts{3, 1};
  const gmis::TabulatedProblem problem(f, mine.proposals, gmis::gauss_legendre_over_line(0.0, 2.0, 32));
  gmis::Philox source = gmis::seeded("planted bugs");
  return gmis::check_estimator([&] { return mine.round(source); }, gmis::exact_moments(counts, problem), 400'000);
}

}  // namespace

// The four planted bugs of docs/test-your-estimator.md. What the mean alone says is a fact of the
// seed, and not checked; that the variance shows the bugs is checked for every seed. `-s` prints
// the figures.
TEST_CASE("planted bugs are found") {
  MyEstimator unbiased;
  unbiased.counts_in_weight = {1.0, 1.0};
  MyEstimator close;
  close.samplers[0].deviation *= 1.02;
  MyEstimator too_large;
  too_large.counts_in_division = {1.0, 1.0};
  MyEstimator cut;
  cut.lost = 3.0;
  for (const MyEstimator& mine : {unbiased, close, too_large, cut}) {
    const auto result = check(mine);
    INFO(result.text());
    CHECK_FALSE(result.passes());
  }
  const double each = gmis::sidak_level(1e-4, 2);
  CHECK_FALSE(check(unbiased).variance_test.passes(each));
  CHECK_FALSE(check(close).variance_test.passes(each));
  const auto sound = check(MyEstimator{});
  INFO(sound.text());
  CHECK(sound.passes());
}
