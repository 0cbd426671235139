#include "support/report/figures.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "support/catch.hpp"
#include "support/report/tables.hpp"

using namespace gmis::tools;

namespace {

/// error = at_one · seconds^slope, from 1/16 s to `last`.
std::vector<gmis::ErrorAtTime> course(double at_one, double slope, double last) {
  std::vector<gmis::ErrorAtTime> points;
  for (double seconds = last; seconds > 1.0 / 16.0; seconds /= 1.25)
    points.insert(points.begin(), {seconds, at_one * std::pow(seconds, slope)});
  return points;
}

}  // namespace

TEST_CASE("Seconds to an error: reached, reached by some, reached by none") {
  // 0.2 s^-1/2 is at 5 % after 16 s, 0.1 s^-1/2 after 4 s: 8 s in the geometric mean.
  const Courses both{course(0.2, -0.5, 64), course(0.1, -0.5, 64)};
  const TimeToError reached = time_to_error(both, 0.05);
  CHECK(reached.reached == 2);
  CHECK(reached.seconds.value() == Approx(8.0));
  CHECK_FALSE(reached.predicted.has_value());
  // 2 %: after 100 s and 25 s.
  const TimeToError half = time_to_error(both, 0.02);
  CHECK(half.reached == 1);
  CHECK_FALSE(half.seconds.has_value());
  CHECK(half.predicted.value() == Approx(50.0));
  // 1 %: after 400 s and 100 s, not measured any more.
  const TimeToError none = time_to_error(both, 0.01);
  CHECK(none.reached == 0);
  CHECK(none.predicted.value() == Approx(200.0));
  CHECK_FALSE(time_to_error(both, 0.001).predicted.has_value());  // after 20,000 s: 300 times as far as was measured
  // One that does not fall will never come there.
  CHECK_FALSE(time_to_error({course(0.2, -0.5, 64), course(0.3, 0.0, 64)}, 0.01).predicted.has_value());
  CHECK_FALSE(time_to_error({}, 0.05).seconds.has_value());
}

TEST_CASE("Efficiency is paired by seed, with Student's interval of its logarithm") {
  // Twice the error in the same time is a quarter of the efficiency; the time at the end counts
  // too.
  const Courses baseline{{{10, 0.1}}, {{10, 0.2}}, {{10, 0.4}}};
  const auto same = relative_efficiency(baseline, baseline);
  CHECK(same->value == Approx(1.0));
  CHECK(same->lower == Approx(1.0));
  CHECK(same->upper == Approx(1.0));
  const Courses worse{{{10, 0.2}}, {{10, 0.4}}, {{20, 0.8}}};
  // Ratios 1/4, 1/4, 1/8. The logarithms base 2, −2, −2, −3, have the mean −7/3 and the standard
  // error 1/3; t for 2 degrees of freedom is 4.302653.
  const auto ratio = relative_efficiency(worse, baseline);
  CHECK(ratio->value == Approx(std::exp2(-7.0 / 3.0)));
  CHECK(ratio->lower == Approx(std::exp2(-7.0 / 3.0 - 4.302652729911275 / 3.0)).epsilon(1e-6));
  CHECK(ratio->upper == Approx(std::exp2(-7.0 / 3.0 + 4.302652729911275 / 3.0)).epsilon(1e-6));
  const auto one = relative_efficiency({{{10, 0.2}}}, baseline);
  CHECK(one->value == Approx(0.25));
  CHECK(one->upper == std::numeric_limits<double>::infinity());
  const auto two = relative_efficiency({{{10, 0.2}}, {{10, 0.4}}}, baseline);
  CHECK(two->value == Approx(0.25));
  CHECK(two->upper == std::numeric_limits<double>::infinity());
  CHECK_FALSE(relative_efficiency({}, baseline).has_value());
}

TEST_CASE("Targets are round, and the smallest is one that was reached") {
  CHECK(round_below(0.0201) == Approx(0.02));
  CHECK(round_below(0.1) == Approx(0.1));
  CHECK(round_above(0.0201) == Approx(0.05));
  CHECK(round_above(0.02) == Approx(0.02));
  CHECK(round_above(0.51) == Approx(1.0));
  const auto check = [](const std::vector<Courses>& all, double most, double next, double least) {
    const auto targets = targets_of(all);
    CHECK(targets[0] == Approx(most));
    CHECK(targets[1] == Approx(next));
    CHECK(targets[2] == Approx(least));
  };
  check({{{{1, 0.5}, {2, 0.3}}}, {{{1, 0.5}, {2, 0.013}}}}, 0.1, 0.05, 0.02);
  check({{{{1, 0.7}}}}, 5, 2, 1);
  check({{}}, 0.05, 0.02, 0.01);
}

TEST_CASE("A band has the lowest, the geometric mean and the highest of the seeds") {
  const Courses courses{course(0.2, -0.5, 64), course(0.4, -0.5, 32), course(0.1, -0.5, 64)};
  const auto band = band_of(courses, 9);
  REQUIRE(band.size() == 9);
  CHECK(band.back().seconds == Approx(32.0));  // no farther than the shortest
  for (const BandPoint& point : band) {
    CHECK(point.lowest == Approx(0.1 / std::sqrt(point.seconds)));
    CHECK(point.mean == Approx(0.2 / std::sqrt(point.seconds)));
    CHECK(point.highest == Approx(0.4 / std::sqrt(point.seconds)));
  }
  CHECK(band_of({}, 9).empty());
  CHECK(band_of({course(0.1, -0.5, 64), {}}, 9).empty());
  CHECK(mean_slope(courses).value() == Approx(-0.5));
  CHECK(last_error({{{1, 0.1}}, {{1, 0.4}}}).value() == Approx(0.2));
}

TEST_CASE("The table says what was measured, and where a target was not reached") {
  const auto contender = [](const char* name, double at_one, bool is_merging) {
    ContenderRecord record;
    record.name = name;
    record.is_merging = is_merging;
    for (const double factor : {0.5, 1.0, 2.0}) {
      RunRecord run;
      run.iterations = 100;
      for (const auto& point : course(at_one * factor, -0.5, 64))
        run.points.push_back({point.seconds, point.seconds, 1, {}, {}, point.error});
      record.runs.push_back(run);
    }
    return record;
  };
  SceneRecord scene;
  scene.name = "room";
  scene.reference_origin = "a file";
  scene.contenders = {contender("pt", 0.4, false), contender("vcm", 0.2, true)};
  scene.contenders[1].bias = gmis::MergingBias{0.004, 0.001};
  const Table table = table_of(scene);
  REQUIRE(table.rows.size() == 2);
  const std::vector<std::string> headings(table.headings.begin() + 3, table.headings.begin() + 6);
  CHECK(headings == std::vector<std::string>{"to 20 %", "to 10 %", "to 5 %"});
  const std::vector<std::string> pt{
      "pt",    "100", "5.00 %", "4.00 s", "16.0 s", "not reached by 1 of 3 (≈ 64.0 s)", "0.250 (0.250 to 0.250)",
      "-0.50", "none"};
  const std::vector<std::string> vcm{"vcm", "100", "2.50 %", "1.00 s", "4.00 s", "16.0 s", "1", "-0.50", "0.400 %"};
  CHECK(table.rows[0] == pt);
  CHECK(table.rows[1] == vcm);
  scene.contenders[0].runs.pop_back();
  CHECK(table_of(scene).rows[0][6] == "0.250 (too few seeds)");
  CHECK(metrics_table_of(scene).rows.empty());
  scene.contenders[1].picture_error = PictureError{{0.1, 0.05, 0.02, 0.03}, {}, {}};
  CHECK(metrics_table_of(scene).rows ==
        std::vector<std::vector<std::string>>{{"vcm", "10.0 %", "5.00 %", "2.00 %", "3.00 %"}});
  scene.contenders[1].bias = gmis::MergingBias{0.001, 0.001};
  CHECK(table_of(scene).rows[1].back() == "below 0.200 %");
  CHECK(reference_warning(scene).empty());
  scene.reference_error = 0.008;  // less than a third of vcm's 2.5 %
  CHECK(reference_warning(scene).empty());
  scene.reference_error = 0.01;
  CHECK(reference_warning(scene).find("not small") != std::string::npos);

  Comparison comparison;
  comparison.scenes = {scene};
  const std::string markdown = markdown_of(comparison);
  CHECK(markdown.find("### room\n\n| integrator | iterations | error at the end | to 20 % |") == 0);
  CHECK(markdown.find("| vcm | 100 | 2.50 % | 1.00 s | 4.00 s | 16.0 s |") != std::string::npos);
  // Columns line up on a terminal.
  const std::string text = text_of(table);
  CHECK(text.find("pt  ") != std::string::npos);
}

TEST_CASE("Three digits") {
  CHECK(three_digits(0) == "0");
  CHECK(three_digits(1234.5) == "1230");
  CHECK(three_digits(12.345) == "12.3");
  CHECK(three_digits(0.0012345) == "0.00123");
  CHECK(percentage(0.05) == "5.00 %");
  CHECK(three_digits(std::numeric_limits<double>::infinity()) == "∞");
}
