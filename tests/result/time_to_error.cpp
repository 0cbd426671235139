#include "gmis/result/time_to_error.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "gmis/result/convergence_log.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

/// The log of a run whose iterations take 2 s of one processor and 0.5 s of wall time each, after
/// 10 and 3 s of pilots.
std::vector<gmis::ConvergencePoint> log_of(std::uint64_t iterations, double at_one, double slope) {
  gmis::ConvergenceLog log;
  for (std::uint64_t i = 1; i <= iterations; ++i) {
    const auto count = static_cast<double>(i);
    if (log.is_due(i)) log.add({10 + 2 * count, 3 + 0.5 * count, i, at_one * std::pow(count, slope), {}, {}});
  }
  return log.points();
}

}  // namespace

TEST_CASE("Prices are reached or predicted, and times go with iterations") {
  const auto log = log_of(512, 0.8, -0.5);
  const auto table = gmis::price_table(log);
  REQUIRE(table.has_value());
  REQUIRE(table->prices.size() == 5);
  CHECK(table->law.independent == Approx(0.64));
  CHECK(table->law.merging == 0.0);
  // (0.8 / error)² iterations: 64, 256, 1600, 6400, 25600.
  const double iterations[] = {64, 256, 1600, 6400, 25600};
  for (std::size_t i = 0; i < 5; ++i) {
    CAPTURE(i);
    const gmis::Price& price = table->prices[i];
    CHECK(price.error == gmis::PriceTable::usual_errors[i]);
    CHECK(price.iterations == Approx(iterations[i]).margin(1.5));  // rounded up
    CHECK(price.cpu_seconds == Approx(10 + 2 * price.iterations));
    CHECK(price.wall_seconds == Approx(3 + 0.5 * price.iterations));
    CHECK(price.is_reached == (iterations[i] <= 512));
  }
}

namespace {

/// The squared error of n iterations, by its definition.
double squared_error(const gmis::ErrorLaw& law, int n) {
  long double sum = 0;
  for (int i = 1; i <= n; ++i)
    sum += law.independent + law.merging * std::pow(static_cast<long double>(i), 1 - law.alpha);
  const double even = n > 8 ? 1 - law.evenness * (1 - std::sqrt(8.0 / n)) : 1.0;
  return even * static_cast<double>(sum / n / n);
}

std::vector<gmis::ConvergencePoint> log_of(const gmis::ErrorLaw& law, int iterations) {
  gmis::ConvergenceLog log;
  for (int i = 1; i <= iterations; ++i)
    if (log.is_due(static_cast<std::uint64_t>(i)))
      log.add({1.0 * i, 1.0 * i, static_cast<std::uint64_t>(i), std::sqrt(squared_error(law, i)), {}, {}});
  return log.points();
}

}  // namespace

TEST_CASE("The law of an error follows its definition, summed by brute force") {
  for (const double alpha : {1.0, 0.75, 0.5, 0.2})
    for (const auto& [independent, merging, evenness] :
         {std::tuple(0.5, 0.0, 0.0), std::tuple(0.3, 0.2, 0.0), std::tuple(0.0, 2.0, 0.0), std::tuple(0.5, 0.0, 0.9),
          std::tuple(0.3, 0.2, 0.4)}) {
      const gmis::ErrorLaw law{independent, merging, alpha, evenness};
      for (const int n : {1, 2, 10, 300, 5000}) {
        CAPTURE(alpha, independent, merging, evenness, n);
        CHECK(law.error_at(n) == Approx(std::sqrt(squared_error(law, n))).epsilon(n == 1 ? 0.01 : 0.004));
        CHECK(law.iterations_to_reach(law.error_at(n)) == Approx(n).epsilon(1e-6));
        const double h = 1e-4;
        const double slope = (std::log(law.error_at(n * (1 + h))) - std::log(law.error_at(n * (1 - h)))) / (2 * h);
        if (n > 10) CHECK(law.slope_at(n) == Approx(slope).margin(0.01));
        CHECK(law.scaled(3).error_at(n) == Approx(3 * law.error_at(n)));
      }
      CHECK(std::isinf(law.iterations_to_reach(0.0)));
      CHECK(law.iterations_to_reach(2 * law.error_at(1)) < 1.0);
    }
  CHECK(gmis::ErrorLaw{0.5, 0.0, 1.0, 0.9}.slope_at(4) == -0.5);  // no replication has a second iteration
  CHECK(gmis::ErrorLaw{0.0, 1.0, 0.5}.merging_share_at(40) == 1.0);
  CHECK(gmis::ErrorLaw{0.0, 0.0, 0.5}.merging_share_at(40) == 0.0);
  CHECK(std::isinf(gmis::ErrorLaw{}.iterations_to_reach(0.1)));
}

TEST_CASE("The price where merging shrinks its disk is that of the fitted law") {
  const double errors[] = {0.05, 0.02};
  for (const double alpha : {0.75, 0.5})
    for (const double merging : {0.02, 0.1, 0.6}) {
      const gmis::ErrorLaw law{0.25, merging, alpha};
      const auto log = log_of(law, 256);
      const auto exact = gmis::price_table(log, errors, law);
      REQUIRE(exact.has_value());
      CAPTURE(alpha, merging, exact->law.independent, exact->law.merging);
      for (const gmis::Price& price : exact->prices)
        CHECK(squared_error(law, static_cast<int>(price.iterations)) ==
              Approx(price.error * price.error).epsilon(5e-3 + 1 / price.iterations));  // rounded up
      // Without a forecast the fit counts for four fifths.
      const auto fitted = gmis::price_table(log, errors, {0.0, 0.0, alpha});
      REQUIRE(fitted.has_value());
      CHECK(fitted->law.merging_share_at(256) == Approx(0.8 * law.merging_share_at(256)).epsilon(0.03));
      CHECK(fitted->law.error_at(256) == Approx(*log.back().estimated_error));
      // With one it does, too, where the last point has an interval; where it has none the forecast
      // counts for two thirds, and the law lies between the two at the last point.
      const gmis::ErrorLaw half{0.25, merging / 2, alpha};
      auto sure = log;
      sure.back().interval = gmis::Interval{};
      for (const auto& [points, trust] : {std::pair{sure, 256.0 / 320}, std::pair{log, 256.0 / 768}}) {
        const auto table = gmis::price_table(points, errors, half);
        REQUIRE(table.has_value());
        // What the error is above the expected one counts as independent.
        const double ratio = half.error_at(256) / *log.back().estimated_error;
        const double known = half.merging_share_at(256) * std::pow(ratio, 2);
        CHECK(table->law.error_at(256) ==
              Approx(*log.back().estimated_error * (points.back().interval ? 1 : std::pow(ratio, 16.0 / 272))));
        CHECK(table->law.merging_share_at(256) ==
              Approx(trust * law.merging_share_at(256) + (1 - trust) * known).epsilon(0.03));
      }
      // What came before an eighth of the run has no part in it.
      auto begun_badly = log;
      for (gmis::ConvergencePoint& point : begun_badly)
        if (point.iteration < 32) *point.estimated_error *= 3;
      const auto later = gmis::price_table(begun_badly, errors, {0.0, 0.0, alpha});
      CHECK(later->law.merging_share_at(256) == fitted->law.merging_share_at(256));
      // Too few points to find anything: what was known stays.
      const auto known = gmis::price_table(log_of(law, 8), errors, law);
      CHECK(known->law.merging_share_at(8) ==
            Approx(law.merging_share_at(8)).epsilon(3e-3));  // sums by the midpoint rule
    }
}

TEST_CASE("The price with evenly spread numbers is that of the fitted law") {
  const double errors[] = {0.02, 0.01};
  for (const double merging : {0.0, 0.1})
    for (const double evenness : {0.0, 0.3, 0.85}) {
      const gmis::ErrorLaw law{0.25, merging, merging > 0.0 ? 0.75 : 1.0, evenness};
      auto log = log_of(law, 256);
      log.back().interval = gmis::Interval{};
      CAPTURE(merging, evenness);
      for (const gmis::ErrorLaw& known : {law, gmis::ErrorLaw{0.0, 0.0, law.alpha, evenness}}) {
        const auto fitted = gmis::price_table(log, errors, known);
        REQUIRE(fitted.has_value());
        CHECK(fitted->law.evenness == evenness);
        CHECK(fitted->law.error_at(256) == Approx(*log.back().estimated_error));
        // A forecast has the true share of merging; without one the fit counts for four fifths.
        const double share = law.merging_share_at(256) * (known.merging > 0.0 ? 1.0 : 0.8);
        CHECK(fitted->law.merging_share_at(256) == Approx(share).epsilon(0.03));
        if (known.merging == merging)
          for (const gmis::Price& price : fitted->prices)
            CHECK(squared_error(law, static_cast<int>(price.iterations)) ==
                  Approx(price.error * price.error).epsilon(5e-3 + 1 / price.iterations));  // rounded up
      }
    }
}

TEST_CASE(
    "Without merging a price goes with the square of the error; a law is never steeper, and never flatter than the "
    "disk") {
  const double two_percent[] = {0.02};
  for (const double slope : {-0.8, -0.5, -0.2, 0.0}) {
    const auto log = log_of(256, 3.0, slope);
    const double last = *log.back().estimated_error;
    const auto plain = gmis::price_table(log, two_percent);
    REQUIRE(plain.has_value());
    CHECK(plain->prices[0].iterations == Approx(std::ceil(256 * std::pow(last / 0.02, 2))));
    const auto merging = gmis::price_table(log, two_percent, {0.0, 0.0, 0.5});
    REQUIRE(merging.has_value());
    CAPTURE(slope);
    CHECK(merging->law.merging_share_at(256) == (slope == -0.8 ? Approx(0.0) : Approx(slope == -0.5 ? 0.0 : 0.8)));
  }
}

TEST_CASE("Prices before a run: iterations by the variance of one, times by those begun with and those to come") {
  // 10 iterations took 8 s of four processors, and 2 s; from then on two of them take 1 s, and 0.25
  // s.
  const double errors[] = {0.5, 0.2, 0.1, 0.03};
  const gmis::PriceTable table = gmis::forecast_prices({0.64, 0.0, 1.0}, {10, 8, 2}, {2, 1, 0.25}, errors);
  REQUIRE(table.prices.size() == 4);
  const double iterations[] = {3, 16, 64, 712};  // 2.56, 16, 64 and 711.1, rounded up
  const double cpu[] = {2.4, 8 + 3, 8 + 27, 8 + 351}, wall[] = {0.6, 2.75, 8.75, 89.75};
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    CHECK(table.prices[i].error == errors[i]);
    CHECK(table.prices[i].iterations == Approx(iterations[i]).margin(i == 1 || i == 2 ? 1.0 : 1e-9));
    if (i == 1 || i == 2) continue;  // rounded up or not
    CHECK(table.prices[i].cpu_seconds == Approx(cpu[i]));
    CHECK(table.prices[i].wall_seconds == Approx(wall[i]));
  }
  CHECK(table.prices[2].cpu_seconds == Approx(cpu[2]).margin(0.5));
  CHECK_FALSE(table.prices[0].is_reached);
  CHECK(table.law.error_at(64) == Approx(0.1));
  CHECK(gmis::forecast_prices({0.64, 0.0, 1.0}, {10, 8, 2}, {2, 1, 0.25}).prices.size() ==
        gmis::PriceTable::usual_errors.size());
}

TEST_CASE("No price without points") {
  CHECK_FALSE(gmis::price_table({}).has_value());
  CHECK_FALSE(gmis::price_table(log_of(7, 0.5, -0.5)).has_value());
  CHECK(gmis::price_table(log_of(8, 0.5, -0.5)).has_value());
  auto nothing = log_of(64, 0.5, -0.5);
  for (auto& point : nothing) point.estimated_error = 0;
  CHECK_FALSE(gmis::price_table(nothing).has_value());
}

// Independent iterations: errors of means of exponential numbers over 400 pixels, whose true price
// is known. The estimate of the squared error, and with it a price by a slope of -1/2, has a
// standard deviation of √(8 / 64 / 400), or 1.8 %: 20 % is eleven of these.
TEST_CASE("The price of half and a quarter of the error is within 20 % for independent iterations") {
  std::mt19937 source(gmis_test::seed(31));
  std::exponential_distribution<double> value(1.0);
  for (int run = 0; run < 10; ++run) {
    std::vector<double> sum(400, 0.0), squares(400, 0.0);
    gmis::ConvergenceLog log;
    for (std::uint64_t i = 1; i <= 64; ++i) {
      const auto count = static_cast<double>(i);
      double error = 0;
      for (std::size_t p = 0; p < sum.size(); ++p) {
        const double x = value(source);
        sum[p] += x;
        squares[p] += x * x;
        if (i > 1) error += (squares[p] / count - std::pow(sum[p] / count, 2)) / (count - 1) / 400;
      }
      if (log.is_due(i)) log.add({count, count, i, std::sqrt(error), {}, {}});
    }
    // The variance of an iteration is 1: the error e takes e^-2 iterations.
    const double errors[] = {1.0 / 16, 1.0 / 32};
    const auto table = gmis::price_table(log.points(), errors);
    REQUIRE(table.has_value());
    CAPTURE(run, table->law.independent, table->prices[0].iterations, table->prices[1].iterations);
    CHECK(table->prices[0].iterations == Approx(256).epsilon(0.2));
    CHECK(table->prices[1].iterations == Approx(1024).epsilon(0.2));
  }
}
