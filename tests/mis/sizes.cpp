#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Scheme;

double cosine(double x) {
  return 1.0 + std::cos(2.0 * test::pi * x) * 0.5;
}  // integral over [0, 1]: 1

template <std::size_t N>
std::array<test::Ramp, N> ramps() {
  std::array<test::Ramp, N> proposals{};
  for (std::size_t k = 0; k < N; ++k)
    proposals[k].slope = N == 1 ? 1.0 : -1.5 + 3.0 * static_cast<double>(k) / static_cast<double>(N - 1);
  return proposals;
}

template <std::size_t N>
void check_size(std::uint64_t estimates) {
  const auto fixed = ramps<N>();
  const std::vector<test::Ramp> dynamic(fixed.begin(), fixed.end());
  // 5 sizes × 15 pairs × 2 round counts; false-alarm rate 1e-4 for the family.
  const double level = test::sidak_level(1e-4, 150);
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings)
      for (const std::uint64_t rounds : {std::uint64_t{1}, std::uint64_t{5}}) {
        CAPTURE(N, name_of(selection), name_of(weighting), rounds);
        gmis::Philox source(gmis_test::seed(11), static_cast<std::uint32_t>(rounds));
        gmis::Philox same_source = source;
        std::vector<double> means;
        for (std::uint64_t i = 0; i < estimates; ++i) {
          const auto a = gmis::estimate(selection, weighting, cosine, fixed, rounds, source);
          const auto b = gmis::estimate(selection, weighting, cosine, dynamic, rounds, same_source);
          REQUIRE(a.mean == b.mean);  // N known at compile time or not: the same bits
          REQUIRE(a.density_evaluations == b.density_evaluations);
          REQUIRE(b.samples == N * rounds);
          REQUIRE(a.samples == N * rounds);
          REQUIRE(a.integrand_evaluations == N * rounds);
          REQUIRE(a.rounds == rounds);
          REQUIRE(a.variance.has_value() == (rounds > 1));
          REQUIRE(a.standard_error.has_value() == (rounds > 1));
          REQUIRE(a.rejected.total() == 0);
          means.push_back(a.mean);
        }
        CHECK(test::mean_p_value(test::moments_of(means), 1.0) > level);
      }
}

}  // namespace

TEST_CASE("one proposal", "[mis]") {
  check_size<1>(2000);
}
TEST_CASE("two proposals", "[mis]") {
  check_size<2>(1000);
}
// The most that are compiled apart as few, and one more.
TEST_CASE("sixteen and seventeen proposals", "[mis]") {
  STATIC_REQUIRE(gmis::few_densities == 16);
  check_size<16>(50);
  check_size<17>(50);
}
TEST_CASE("sixty-four proposals", "[mis]") {
  check_size<64>(20);
}

TEST_CASE("with one proposal all schemes are plain importance sampling", "[mis]") {
  const auto proposals = ramps<1>();
  gmis::Philox by_hand(gmis_test::seed(3));
  std::array<double, 4> expected{};
  for (double& value : expected) {
    const double x = proposals[0].sample(by_hand);
    value = cosine(x) / proposals[0].pdf(x);
  }
  for (const Scheme scheme : gmis::all_schemes) {
    gmis::Philox source(gmis_test::seed(3));
    for (const double value : expected)
      CHECK(gmis::estimate(scheme, cosine, proposals, 1, source).mean == Approx(value).epsilon(1e-14));
  }
}

TEST_CASE("the variance and standard error of an estimate are those of its rounds", "[mis]") {
  const auto proposals = ramps<2>();
  gmis::Philox source(gmis_test::seed(17));
  std::vector<double> rounds;
  for (int i = 0; i < 5; ++i) rounds.push_back(gmis::estimate<Scheme::N3>(cosine, proposals, 1, source).mean);
  const auto expected = test::moments_of(rounds);
  gmis::Philox same_source(gmis_test::seed(17));
  const auto together = gmis::estimate<Scheme::N3>(cosine, proposals, 5, same_source);
  CHECK(together.mean == Approx(expected.mean).epsilon(1e-14));
  CHECK(together.variance.value() == Approx(expected.variance).epsilon(1e-12));
  CHECK(together.standard_error.value() == Approx(expected.standard_error).epsilon(1e-12));
}

TEST_CASE("4096 proposals with a workspace of the caller's", "[mis]") {
  const std::vector<test::Ramp> proposals(4096, test::Ramp{0.5});
  const auto set = gmis::as_proposal_set(proposals);
  gmis::Workspace<double, 4096> workspace;
  for (const Scheme scheme : gmis::all_schemes) {
    gmis::Philox source(gmis_test::seed(1));
    double sum = 0.0;
    double by_hand = 0.0;
    const auto counts = gmis::dispatch(scheme, [&](auto fixed) {
      return gmis::sample_round<decltype(fixed)::value>(set, gmis::EqualAllocation{}, source, workspace,
                                                        [&](double x, double denominator, std::size_t) {
                                                          sum += cosine(x) / denominator;
                                                          by_hand += cosine(x) / proposals[0].pdf(x);
                                                        });
    });
    CHECK(sum == Approx(by_hand).epsilon(1e-12));  // all proposals are equal, so every mixture is
    CHECK(counts.failed_samples + counts.zero_density + counts.non_finite_density == 0);
  }
}

// Welford's update, merged in two halves, against two passes in long double over numbers with a
// large common part.
TEST_CASE("moments neither cancel nor depend on how they were split", "[mis]") {
  gmis::Philox source(gmis_test::seed(23));
  std::vector<double> values(10000);
  for (double& value : values) value = 1e9 + gmis::uniform<double>(source);
  const auto expected = test::moments_of(values);
  gmis::Moments<double> whole, first, second;
  for (std::size_t i = 0; i < values.size(); ++i) {
    whole.add(values[i]);
    (i < 3000 ? first : second).add(values[i]);
  }
  first.merge(second);
  for (const auto& moments : {whole, first}) {
    CHECK(moments.count() == values.size());
    CHECK(moments.mean() == Approx(expected.mean).epsilon(1e-15));
    CHECK(moments.variance() == Approx(expected.variance).epsilon(1e-6));
  }
}
