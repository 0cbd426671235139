#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using Counts = std::vector<std::uint32_t>;

template <class T, class H>
std::vector<T> weights_of(const H& heuristic, const Counts& counts, const std::vector<T>& densities) {
  std::vector<T> weights(densities.size());
  gmis::heuristic_weights(heuristic, std::span<const std::uint32_t>(counts), std::span<const T>(densities),
                          std::span<T>(weights));
  return weights;
}

/// Uniform up to 1 or `infinite_from`, from where it states an infinite density.
struct Stating {
  double infinite_from;
  double sample(auto& source) const { return std::min(infinite_from, 1.0) * gmis::uniform<double>(source); }
  double pdf(double x) const {
    if (x >= infinite_from) return std::numeric_limits<double>::infinity();
    return 1.0 / std::min(infinite_from, 1.0);
  }
};
/// Uniform over an interval of the length 1 / `density`.
struct Narrow {
  float density;
  float sample(auto& source) const { return gmis::uniform<float>(source) / density; }
  float pdf(float) const { return density; }
};

template <class H>
void check_sums(const H& heuristic) {
  gmis::Philox source(gmis_test::seed(10));
  for (int trial = 0; trial < 2000; ++trial) {
    const std::size_t n = 1 + gmis::uniform_index(source, 8);
    Counts counts(n);
    std::vector<double> densities(n), logs(n), from_logs(n);
    for (std::size_t i = 0; i < n; ++i) {
      counts[i] = gmis::uniform_index(source, 5);
      logs[i] = 1380.0 * gmis::uniform<double>(source) - 690.0;  // 1e-300 … 1e300
      if (gmis::uniform_index(source, 6) == 0) logs[i] = -std::numeric_limits<double>::infinity();
      densities[i] = std::exp(logs[i]);
    }
    counts[0] = 1;
    if (densities[0] == 0.0) {
      logs[0] = 0.0;
      densities[0] = 1.0;
    }
    const auto weights = weights_of(heuristic, counts, densities);
    CHECK(std::accumulate(weights.begin(), weights.end(), 0.0) == Approx(1.0).epsilon(1e-14));
    gmis::heuristic_weights_from_logs(heuristic, std::span<const std::uint32_t>(counts), std::span<const double>(logs),
                                      std::span<double>(from_logs));
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(weights[i] >= 0.0);
      if (counts[i] == 0 || densities[i] == 0.0) CHECK(weights[i] == 0.0);
      CHECK(from_logs[i] == Approx(weights[i]).epsilon(1e-9).margin(1e-300));
    }
  }
}

}  // namespace

TEST_CASE("heuristics sum to one, for densities from 1e-300 to 1e300", "[mis]") {
  check_sums(gmis::Balance{});
  check_sums(gmis::Power{});
  check_sums(gmis::Power{3.5});
  check_sums(gmis::Power{0.5});
  check_sums(gmis::Cutoff{});
  check_sums(gmis::Cutoff{0.9});
  check_sums(gmis::Maximum{});
}

TEST_CASE("heuristics are Veach's", "[mis]") {
  const Counts counts{1, 2, 4};
  const std::vector<double> p{3.0, 1.0, 0.05};  // d = 3, 2, 0.2
  const auto near = [](const std::vector<double>& a, const std::vector<double>& b) {
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i] - b[i]) > 1e-14) return false;
    return true;
  };
  CHECK(near(weights_of(gmis::Balance{}, counts, p), {3.0 / 5.2, 2.0 / 5.2, 0.2 / 5.2}));
  CHECK(near(weights_of(gmis::Power{2.0}, counts, p), {9.0 / 13.04, 4.0 / 13.04, 0.04 / 13.04}));
  CHECK(near(weights_of(gmis::Power{1.0}, counts, p), weights_of(gmis::Balance{}, counts, p)));
  CHECK(near(weights_of(gmis::Cutoff{0.1}, counts, p), {0.6, 0.4, 0.0}));
  CHECK(near(weights_of(gmis::Cutoff{0.1}, Counts{1, 1}, std::vector<double>{1.0, 0.1004}),
             {1 / 1.1004, 0.1004 / 1.1004}));
  CHECK(near(weights_of(gmis::Cutoff{0.1}, Counts{1, 1}, std::vector<double>{1.0, 0.0996}), {1.0, 0.0}));
  CHECK(near(weights_of(gmis::Cutoff{0.0}, counts, p), weights_of(gmis::Balance{}, counts, p)));
  CHECK(near(weights_of(gmis::Maximum{}, counts, p), {1.0, 0.0, 0.0}));
  CHECK(near(weights_of(gmis::Maximum{}, Counts{2, 2, 1}, std::vector<double>{1.0, 1.0, 1.0}), {0.5, 0.5, 0.0}));
}

TEST_CASE("heuristics at the ends of the range of numbers", "[mis]") {
  const double largest = std::numeric_limits<double>::max(), infinity = std::numeric_limits<double>::infinity();
  const double smallest = std::numeric_limits<double>::denorm_min();
  const auto balance = [](const std::vector<double>& p) { return weights_of(gmis::Balance{}, Counts(p.size(), 3), p); };
  CHECK(balance({largest, largest}) == std::vector<double>{0.5, 0.5});
  CHECK(balance({smallest, smallest}) == std::vector<double>{0.5, 0.5});
  CHECK(balance({largest, smallest}) == std::vector<double>{1.0, 0.0});
  CHECK(balance({infinity, 1.0}) == std::vector<double>{1.0, 0.0});
  CHECK(balance({infinity, infinity}) == std::vector<double>{0.5, 0.5});
  CHECK(balance({0.0, 0.0}) == std::vector<double>{0.0, 0.0});
  CHECK(std::isnan(balance({std::nan(""), 1.0})[0]));
  CHECK(std::isnan(balance({-1.0, 1.0})[1]));
  const auto in_float = weights_of(gmis::Power{}, Counts{1, 1}, std::vector<float>{3e38F, 1e-38F});
  CHECK(in_float == std::vector<float>{1.0F, 0.0F});
}

// 7 heuristics × 2 divisions of the samples; false-alarm rate 1e-4 for the family.
TEST_CASE("the multi-sample form is unbiased under every heuristic, with partial support too", "[mis]") {
  const std::array<test::Uniform, 3> proposals{{{0.0, 0.6}, {0.3, 1.0}, {0.5, 0.9}}};
  const auto f = [](double x) { return 3.0 * x * x; };
  const double level = test::sidak_level(1e-4, 14);
  const auto check = [&](const auto& heuristic) {
    for (const auto& counts : {std::array<std::uint32_t, 3>{1, 1, 1}, std::array<std::uint32_t, 3>{1, 3, 2}}) {
      gmis::Philox source(gmis_test::seed(55));
      const auto estimate =
          gmis::estimate_weighted(heuristic, f, proposals, 20000, source, gmis::SampleAllocation<double>(counts));
      CAPTURE(estimate.mean, estimate.standard_error.value());
      CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > level);
      CHECK(estimate.standard_error.value() < 0.01);
      CHECK(estimate.rejected.total() == 0);
    }
  };
  check(gmis::Balance{});
  check(gmis::Power{});
  check(gmis::Power{5.0});
  check(gmis::Power{0.3});
  check(gmis::Cutoff{});
  check(gmis::Cutoff{0.8});
  check(gmis::Maximum{});
}

TEST_CASE("a sample that densities without a finite value take away is counted", "[mis]") {
  // The second proposal, never drawn beyond .9, states an infinite density there.
  const std::array<Stating, 2> proposals{{{2.0}, {0.9}}};
  const auto one = [](double) { return 1.0; };
  const auto count = [&](const auto& heuristic) {
    gmis::Philox source(gmis_test::seed(56));
    return gmis::estimate_weighted(heuristic, one, proposals, 2000, source).rejected.non_finite_density;
  };
  const auto drawn_beyond = count(gmis::Balance{});
  CHECK(drawn_beyond > 100);
  CHECK(count(gmis::Power{}) == drawn_beyond);
  CHECK(count(gmis::Cutoff{}) == drawn_beyond);
  CHECK(count(gmis::Maximum{}) == drawn_beyond);

  // Densities near the largest float: what the division takes beyond it is counted, too.
  const std::array<Narrow, 2> dense{{{3e38F}, {1.5e38F}}};
  gmis::Philox source(gmis_test::seed(57));
  const auto estimate = gmis::estimate_weighted(
      gmis::Power{}, [](float) { return 1.5e38F; }, dense, 100, source);
  CHECK(estimate.rejected.non_finite_density == 100);
}

// A tenth of the samples of the first proposal have the weight 1e-320, whose inverse is out of
// range.
TEST_CASE("a weight that is too small to divide by is no fault of a density", "[mis]") {
  const std::array<test::Uniform, 2> proposals{{{0.0, 1.0}, {0.0, 0.1}}};
  gmis::Philox source(gmis_test::seed(58));
  const auto one = [](double) { return 1.0; };
  const auto estimate = gmis::estimate_weighted(gmis::Power{320.0}, one, proposals, 4000, source);
  CHECK(estimate.rejected.total() == 0);
  CHECK(test::normal_p_value((estimate.mean - 1.0) / estimate.standard_error.value()) > 1e-4);
}

TEST_CASE("the balance heuristic is N3", "[mis]") {
  const std::array<test::Normal, 3> proposals{{{-1.0, 1.0}, {0.0, 2.0}, {2.0, 0.7}}};
  const auto f = [](double x) { return std::exp(-x * x); };
  const gmis::SampleAllocation<double> allocation(std::array<std::uint32_t, 3>{2, 1, 3});
  gmis::Philox source(gmis_test::seed(5)), same_source(gmis_test::seed(5));
  const auto balance = gmis::estimate_weighted(gmis::Balance{}, f, proposals, 100, source, allocation);
  const auto n3 = gmis::estimate<gmis::Scheme::N3>(f, proposals, 100, same_source, allocation);
  CHECK(balance.mean == Approx(n3.mean).epsilon(1e-12));
  CHECK(balance.variance.value() == Approx(n3.variance.value()).epsilon(1e-10));
  CHECK(balance.density_evaluations == n3.density_evaluations);
}
