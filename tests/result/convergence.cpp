#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/result/budget.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/error_fit.hpp"
#include "support/catch.hpp"

TEST_CASE("Student's quantiles are those of the tables") {
  CHECK(gmis::student_t_quantile(0.975, 1) == Approx(12.7062047362).epsilon(1e-9));
  CHECK(gmis::student_t_quantile(0.975, 7) == Approx(2.36462425159).epsilon(1e-9));
  CHECK(gmis::student_t_quantile(0.975, 15) == Approx(2.13144954556).epsilon(1e-9));
  CHECK(gmis::student_t_quantile(0.025, 15) == Approx(-2.13144954556).epsilon(1e-9));
  CHECK(gmis::student_t_quantile(0.9995, 3) == Approx(12.9239786366).epsilon(1e-9));
  CHECK(gmis::student_t_quantile(0.5, 3) == Approx(0).margin(1e-9));
  CHECK(std::isnan(gmis::student_t_quantile(1.0, 3)));
}

TEST_CASE("A log has few points, of all decades alike") {
  gmis::ConvergenceLog log;
  for (std::uint64_t i = 1; i <= 100000; ++i)
    if (log.is_due(i)) log.add({0.0, 0.0, i, {}, {}, {}});
  std::vector<std::uint64_t> first;
  for (const auto& point : log.points())
    if (point.iteration <= 20) first.push_back(point.iteration);
  CHECK(first == std::vector<std::uint64_t>{1, 4, 6, 8, 12, 16});
  CHECK(log.points().size() == 31);  // 1, and 30 from 4 to 98304
  for (std::size_t i = 1; i < log.points().size(); ++i) {
    const auto before = log.points()[i - 1].iteration, after = log.points()[i].iteration;
    CHECK(after > before);
    if (before >= 4) CHECK(2 * after <= 3 * before);
    if (after >= 4) CHECK(after % (std::bit_floor(after) / 2) == 0);
  }
}

TEST_CASE("The lines of a log have the header's columns, empty where nothing is known") {
  const std::string header = gmis::convergence_csv_header();
  const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  CHECK(gmis::convergence_csv_row({0.5, 0.25, 1, {}, {}, {}}) == "0.5,0.25,1,,,,");
  const std::string full =
      gmis::convergence_csv_row({12.5, 6.25, 1024, 0.0125, gmis::Interval{0.0125, 0.012, 0.013}, 1.5e-7});
  CHECK(full == "12.5,6.25,1024,0.0125,0.012,0.013,1.5e-07");
  CHECK(commas(header) == commas(full));
}

TEST_CASE("The first limit met ends a run") {
  using gmis::Budget;
  using gmis::StopReason;
  const Budget all{100, 10.0, 0.05};
  CHECK_FALSE(all.reason_to_stop({10, 1.0, 0.5, true}).has_value());
  CHECK(all.reason_to_stop({100, 1.0, 0.5}) == StopReason::iterations);
  CHECK(all.reason_to_stop({10, 1.0, 0.05, true}) == StopReason::error);
  CHECK_FALSE(all.reason_to_stop({10, 1.0, 0.05, false}).has_value());  // what is in doubt ends nothing, such as …
  CHECK_FALSE(all.reason_to_stop({10, 1.0, 0.0, false}).has_value());   // … an error of 0 where nothing was found
  CHECK_FALSE(all.reason_to_stop({7, 1.0, 0.01, true}).has_value());    // too few to know the error
  CHECK(all.reason_to_stop({10, 10.0, 0.5}) == StopReason::time);
  // Iterations of a second each: at 9.4 the tenth would end nearer to the limit than the ninth did;
  // at 9.5 it would not.
  CHECK_FALSE(all.reason_to_stop({9, 9.0, 0.5}).has_value());
  CHECK(all.reason_to_stop({9, 9.5, 0.5}) == StopReason::time);
  CHECK_FALSE(Budget{}.reason_to_stop({1000000, 1e9, 1e-9}).has_value());
}

TEST_CASE("A fitted power law gives back the law that made the points") {
  for (const double slope : {-0.5, -0.33, -0.05}) {
    std::vector<gmis::ErrorAtTime> points;
    for (int i = 0; i < 60; ++i) {
      const double seconds = 0.01 * std::pow(1.2, i);
      points.push_back({seconds, 0.7 * std::pow(seconds, slope)});
    }
    points.insert(points.begin(), {0.0, 5.0});  // an error at no time is no point of a power law
    for (gmis::ErrorAtTime& point : points)     // neither is what a run begins with, its first sixteenth
      if (point.seconds < points.back().seconds / 16) point.error *= 3;
    const auto law = gmis::fit_power_law(points);
    REQUIRE(law.has_value());
    CHECK(law->is_fitted);
    CHECK(law->slope == Approx(slope).epsilon(1e-9));
    CHECK(law->error_at(30.0) == Approx(0.7 * std::pow(30.0, slope)).epsilon(1e-9));
    CHECK(law->seconds_to_reach(law->error_at(1234.0)) == Approx(1234.0).epsilon(1e-6));
  }
}

TEST_CASE("No law is steeper than that of independent samples") {
  std::vector<gmis::ErrorAtTime> points;
  for (int i = 0; i < 40; ++i) {
    const double seconds = std::pow(1.2, i);
    points.push_back({seconds, 2.0 * std::pow(seconds, -0.8)});
  }
  const auto law = gmis::fit_power_law(points);
  REQUIRE(law.has_value());
  CHECK(law->is_fitted);
  CHECK(law->slope == -0.5);
}

TEST_CASE(
    "With too little to fit the slope is -1/2, with nothing there is no law, and what does not fall takes for ever") {
  const std::vector<gmis::ErrorAtTime> few{{1.0, 0.2}, {4.0, 0.11}};
  const auto law = gmis::fit_power_law(few);
  REQUIRE(law.has_value());
  CHECK_FALSE(law->is_fitted);
  CHECK(law->seconds_to_reach(0.055) == Approx(16.0));
  CHECK_FALSE(gmis::fit_power_law(std::vector<gmis::ErrorAtTime>{}).has_value());
  CHECK_FALSE(gmis::fit_power_law(std::vector<gmis::ErrorAtTime>{{1.0, 0.0}}).has_value());
  std::vector<gmis::ErrorAtTime> flat;
  for (int i = 1; i < 40; ++i) flat.push_back({static_cast<double>(i), 0.3});
  CHECK(gmis::fit_power_law(flat)->seconds_to_reach(0.1) == std::numeric_limits<double>::infinity());
}

TEST_CASE("The time to an error is where the curve goes below it for good") {
  const std::vector<gmis::ErrorAtTime> points{{1.0, 0.4}, {2.0, 0.09}, {3.0, 0.2}, {4.0, 0.1}, {16.0, 0.05}};
  CHECK_FALSE(gmis::seconds_until(points, 0.04).has_value());
  CHECK(*gmis::seconds_until(points, 0.05) == Approx(16.0));
  CHECK(*gmis::seconds_until(points, 0.1) == Approx(4.0));  // it was there at 2 s by luck, and left again
  CHECK(*gmis::seconds_until(points, 0.5) == Approx(1.0));
  // Halfway in logarithms between 4 s and 16 s.
  CHECK(*gmis::seconds_until(points, std::sqrt(0.1 * 0.05)) == Approx(8.0));
  CHECK_FALSE(gmis::seconds_until(std::vector<gmis::ErrorAtTime>{}, 0.5).has_value());
}
