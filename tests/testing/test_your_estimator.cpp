#include <gmis/mis/diagnostics.hpp>
#include <gmis/mis/methods.hpp>
#include <gmis/testing/catch.hpp>
#include <vector>

#include "my_estimator.hpp"

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

// The four planted bugs of docs/test-your-estimator.md. What the mean alone says is a fact of the seed, and not checked; that
// the variance shows the bugs is checked for every seed. `-s` prints the figures.
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
