#include <cmath>
#include <limits>
#include <stdexcept>

#include "gmis/mis/diagnostics.hpp"
#include "gmis/testing.hpp"
#include "gmis/testing/catch.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The check itself: its false-alarm rate and its power, measured over seeds.

namespace {

/// −log u: mean 1, variance 1, and squared deviations with a skewness of 6.
struct Exponential {
  gmis::Philox source;
  double scale = 1.0, shift = 0.0;
  double operator()() { return 1.0 + shift + scale * (-std::log(1.0 - gmis::uniform<double>(source)) - 1.0); }
};

}  // namespace

// 4000 checks at the levels 0.05 and 0.01: failures are binomial, within 4.5 standard deviations
// (2.4e-5 for both).
TEST_CASE("check_estimator raises false alarms at its stated rate", "[testing]") {
  for (const double level : {0.05, 0.01}) {
    int failures = 0;
    for (std::uint64_t trial = 0; trial < 4000; ++trial) {
      Exponential round{gmis::Philox(gmis_test::seed(71), static_cast<std::uint32_t>(trial))};
      if (!gmis::check_estimator(round, {1.0, 1.0}, 4000, level).passes()) ++failures;
    }
    CAPTURE(level, failures);
    CHECK(failures < 4000.0 * level + 4.5 * std::sqrt(4000.0 * level));
    CHECK(failures > 4000.0 * level - 4.5 * std::sqrt(4000.0 * level));
  }
}

// Squared deviations about the measured mean would all err alike where both values are equally
// likely. 3 × 1000 checks at the level 0.01: more than 65 failures have a probability of 8e-9.
// Fewer than 30 are no fault: where the two figures tell the same, both fail together.
TEST_CASE("check_estimator: rounds of two values keep the rate, and a wrong variance is found", "[testing]") {
  int failures = 0, found = 0;
  for (const double share : {0.5, 0.45, 0.1})
    for (std::uint32_t trial = 0; trial < 1000; ++trial) {
      gmis::Philox source(gmis_test::seed(74), trial, static_cast<std::uint32_t>(100 * share));
      const auto round = [&] { return gmis::uniform<double>(source) < share ? 1.0 / share : 0.0; };
      const double variance = 1.0 / share - 1.0;
      if (!gmis::check_estimator(round, {1.0, variance}, 4000, 0.01).passes()) ++failures;
      if (trial < 20 && !gmis::check_estimator(round, {1.0, 1.5 * variance}, 4000, 0.01).passes()) ++found;
    }
  CHECK(failures <= 65);
  CHECK(found == 60);
}

// 200 seeds each: an error of the size that the check says it sees is seen in 99 of 100. More than
// 10 misses in 200 have a probability of 8e-6; the t of a variance that is larger has a spread that
// is larger, so that more are missed there.
TEST_CASE("check_estimator sees the errors that it says it sees", "[testing]") {
  constexpr std::uint64_t rounds = 20000;
  Exponential sound{gmis::Philox(gmis_test::seed(72))};
  const auto power = gmis::check_estimator(sound, {1.0, 1.0}, rounds);
  CHECK(power.smallest_mean_error == Approx((4.056 + 2.326) / std::sqrt(20000.0)).epsilon(0.02));
  // The variance of (x − 1)² is 8 for this distribution.
  CHECK(power.smallest_variance_error == Approx(power.smallest_mean_error * std::sqrt(8.0)).epsilon(0.2));
  const auto missed = [&](double mean_error, double variance_error) {
    int count = 0;
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
      Exponential round{gmis::Philox(gmis_test::seed(73), static_cast<std::uint32_t>(trial)),
                        std::sqrt(1.0 + variance_error), mean_error};
      if (gmis::check_estimator(round, {1.0, 1.0}, rounds).passes()) ++count;
    }
    return count;
  };
  const double mean_error = power.smallest_mean_error, variance_error = power.smallest_variance_error;
  const int of_mean = missed(mean_error, 0.0), of_lower = missed(0.0, -variance_error),
            of_higher = missed(0.0, variance_error);
  CAPTURE(of_mean, of_lower, of_higher, mean_error, variance_error);
  CHECK(of_mean <= 10);
  CHECK(of_lower <= 10);
  CHECK(of_higher <= 20);
  // Half of it is missed more often than seen: the figure is no overstatement either.
  const int half_of_mean = missed(mean_error / 2.0, 0.0), half_of_variance = missed(0.0, variance_error / 2.0);
  CAPTURE(half_of_mean, half_of_variance);
  CHECK(half_of_mean > 100);
  CHECK(half_of_variance > 100);
}

TEST_CASE("check_estimator: rounds that are not numbers, and rounds without variance", "[testing]") {
  gmis::Philox source = gmis::seeded("not numbers");
  int calls = 0;
  const auto sometimes = [&] {
    return ++calls == 7 ? std::numeric_limits<double>::quiet_NaN() : gmis::uniform<double>(source);
  };
  const auto check = gmis::check_estimator(sometimes, {0.5, 1.0 / 12.0}, 1000);
  CHECK(check.not_finite == 1);
  CHECK_FALSE(check.passes());
  CHECK(std::isfinite(check.mean));
  CHECK(check.text().find("FAILS") != std::string::npos);

  const auto third = [] { return 1.0 / 3.0; };
  CHECK(gmis::check_estimator(third, {1.0 / 3.0, 0.0}, 100).passes());
  CHECK(gmis::check_estimator(third, {1.0 / 3.0 + 1e-16, 1e-32}, 100).passes());
  CHECK_FALSE(gmis::check_estimator(third, {0.34, 0.0}, 100).passes());
  CHECK_FALSE(gmis::check_estimator(third, {1.0 / 3.0, 0.1}, 100).passes());
  const auto no_numbers = gmis::check_estimator([] { return std::nan(""); }, {0.0, 1.0}, 100);
  CHECK_FALSE(no_numbers.passes());
  CHECK(std::isnan(no_numbers.mean));  // nothing was measured
  CHECK(std::isnan(no_numbers.variance));
  CHECK(no_numbers.mean_test.p_value == 0.0);

  CHECK_THROWS_AS(gmis::check_estimator(third, {0.0, 1.0}, 99), std::invalid_argument);
  CHECK_THROWS_AS(gmis::check_estimator(third, {0.0, 1.0}, 100, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(gmis::check_estimator(third, {0.0, std::numeric_limits<double>::infinity()}, 100),
                  std::invalid_argument);
}

// The same rounds in other units: the same verdict, and figures in these units.
TEST_CASE("check_estimator: rounds of any size", "[testing]") {
  for (const double size : {1e-152, 1e-100, 1e-55, 1.0, 1e52, 1e77, 1e150}) {
    const auto check_of = [&](double variance) {
      gmis::Philox source = gmis::seeded("rounds of any size");
      return gmis::check_estimator([&] { return size * gmis::uniform<double>(source); }, {size / 2.0, variance}, 20000);
    };
    const double variance = size * size / 12.0;
    const auto sound = check_of(variance), off = check_of(1.1 * variance);
    CAPTURE(size, sound.text());
    CHECK(sound.passes());
    CHECK(sound.variance == Approx(variance).epsilon(0.05));
    CHECK(sound.mean == Approx(size / 2.0).epsilon(0.05));
    // The variance of (x − 1/2)² is 1/180, 0.8 in units of 1/12 squared.
    CHECK(sound.smallest_variance_error == Approx((4.056 + 2.326) * std::sqrt(0.8 / 20000.0)).epsilon(0.05));
    CHECK_FALSE(off.passes());
  }
}

TEST_CASE("check_estimator: a variance that overflows fails, although each round is finite", "[testing]") {
  for (const double size : {1e200, 1e308}) {
    int calls = 0;
    const auto check = gmis::check_estimator([&] { return ++calls % 2 == 0 ? size : -size; }, {0.0, 1.0}, 1000);
    CAPTURE(check.text());
    CHECK(check.not_finite == 0);
    CHECK(check.variance == std::numeric_limits<double>::infinity());
    CHECK(check.variance_test.p_value == 0.0);
    CHECK_FALSE(check.passes());
  }
  // A sum that overflows is no evidence of the mean.
  const auto huge = gmis::check_estimator([] { return 1e308; }, {0.0, 1.0}, 1000);
  CHECK(huge.mean_test.p_value == 0.0);
  CHECK_FALSE(huge.passes());
}

TEST_CASE("seeded: sources differ by name and are the same again", "[testing]") {
  auto a = gmis::seeded("a"), again = gmis::seeded("a"), b = gmis::seeded("b");
  const auto first = a();
  CHECK(first == again());
  CHECK(first != b());
}
