#include "gmis/result/price.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gmis/result/convergence_log.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

/// The log of a run whose iterations take 2 s of one processor and 0.5 s of wall time each, after 10 and 3 s of pilots.
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
  CHECK(table->law.slope == Approx(-0.5));
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

TEST_CASE("A law is flatter than -1/2 where errors fall more slowly, and never steeper") {
  const double two_percent[] = {0.02};
  const auto flat = gmis::price_table(log_of(256, 0.5, -1.0 / 3), two_percent);
  REQUIRE(flat.has_value());
  CHECK(flat->law.slope == Approx(-1.0 / 3));
  CHECK(flat->prices[0].iterations == Approx(std::pow(25.0, 3)).epsilon(1e-3));
  const auto log = log_of(256, 3.0, -0.8);
  const auto steep = gmis::price_table(log, two_percent);
  CHECK(steep->law.slope == -0.5);
  const double last = *log.back().estimated_error;
  CHECK(steep->prices[0].iterations == Approx(256 * std::pow(last / 0.02, 2)).epsilon(1e-3));
}

TEST_CASE("Prices before a run: iterations by the variance of one, times by those begun with and those to come") {
  // 10 iterations took 8 s of four processors, and 2 s; from then on two of them take 1 s, and 0.25 s.
  const double errors[] = {0.5, 0.2, 0.1, 0.03};
  const gmis::PriceTable table = gmis::forecast_prices(0.64, {10, 8, 2}, {2, 1, 0.25}, errors);
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
  CHECK_FALSE(table.law.is_fitted);
  CHECK(table.law.error_at(64) == Approx(0.1));
  CHECK(gmis::forecast_prices(0.64, {10, 8, 2}, {2, 1, 0.25}).prices.size() == gmis::PriceTable::usual_errors.size());
}

TEST_CASE("No price without points, and none where the error does not fall") {
  CHECK_FALSE(gmis::price_table({}).has_value());
  CHECK_FALSE(gmis::price_table(log_of(7, 0.5, -0.5)).has_value());
  CHECK(gmis::price_table(log_of(8, 0.5, -0.5)).has_value());
  auto nothing = log_of(64, 0.5, -0.5);
  for (auto& point : nothing) point.estimated_error = 0;
  CHECK_FALSE(gmis::price_table(nothing).has_value());
  const auto flat = gmis::price_table(log_of(256, 0.3, 0.0));
  REQUIRE(flat.has_value());
  CHECK_FALSE(flat->prices[0].is_reached);
  CHECK(std::isinf(flat->prices[0].iterations));
  CHECK(std::isinf(flat->prices[0].wall_seconds));
}

// Independent iterations: errors of means of exponential numbers over 400 pixels, whose true price is known. The estimate of the
// squared error, and with it a price by a slope of -1/2, has a standard deviation of √(8 / 64 / 400), or 1.8 %. Fitted slopes had
// one of 0.0125 here, so that 0.05 is four of these: 1 in 30,000 runs, or a false alarm in 3,000 seeds.
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
    CAPTURE(run, table->law.slope, table->prices[0].iterations, table->prices[1].iterations);
    CHECK(table->prices[0].iterations == Approx(256).epsilon(0.2));
    CHECK(table->prices[1].iterations == Approx(1024).epsilon(0.2));
  }
}
