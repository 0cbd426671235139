#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gmis/benchmark/contender.hpp"
#include "gmis/core/argument_error.hpp"
#include "gmis/core/ieee.hpp"
#include "gmis/core/random.hpp"

namespace gmis {

/// How long `compare` times and measures.
struct ComparisonSettings {
  int slices = 7;                 ///< slices of time that each contender gets; the fastest counts
  double slice_seconds = 0.002;   ///< length of one
  double measure_seconds = 0.04;  ///< for the variance of each, at least 400 rounds and at most 1,000,000
  std::uint64_t seed = 1;         ///< of all samples
  /// Returns the processor time so far, in seconds. Tests replace it to make a comparison a
  /// function of the seed.
  std::function<double()> clock = [] {
    return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
  };
};

/// One contender's figures.
struct ComparisonRow {
  std::string name;                  ///< of the contender
  bool is_exact = false;             ///< `variance` is by quadrature, not measured
  double variance = 0.0;             ///< of one round
  double half_width = 0.0;           ///< of the interval of `variance`: 95 % if measured, 99 % if averaged, else 0
  std::optional<double> exact_mean;  ///< by quadrature, where weights may not sum to one
  double measured_mean = 0.0;        ///< over the rounds below
  double mean_error = 0.0;           ///< standard error of `measured_mean`
  double measured_variance = 0.0;    ///< over the rounds below, also where the variance is exact
  double measured_half_width = 0.0;  ///< of its 95 % interval, by the fourth moment; too small with heavy tails
  /// Number of rounds behind the measured figures.
  std::uint64_t measured_rounds = 0;
  double nanoseconds = 0.0;          ///< of one round
  double density_evaluations = 0.0;  ///< in one round; NaN where a round does not say
  double efficiency = 0.0;           ///< 1/(variance × seconds)
  double seconds_to_1_percent =
      0.0;  ///< to a relative standard error of 1 %: 100 times less to 10 %, 100 times more to 0.1 %

  /// True when the exact mean is off by more than a millionth.
  [[nodiscard]] bool has_wrong_exact_mean(double integral) const noexcept {
    return exact_mean && !(std::abs(*exact_mean - integral) <= 1e-6 * std::abs(integral));
  }
  /// True when the exact mean is off, or the measured one by more than five standard errors and by
  /// more than rounding.
  [[nodiscard]] bool has_wrong_mean(double integral) const noexcept {
    if (has_wrong_exact_mean(integral)) return true;
    return !(std::abs(measured_mean - integral) <= 5.0 * mean_error + 1e-9 * std::abs(integral));
  }
  /// True when the measured variance is above the exact one, which is finite, by more than five
  /// standard errors of both and by more than rounding.
  [[nodiscard]] bool has_wrong_variance() const noexcept {
    const double rounding = 1e-6 * measured_variance + 1e-18 * measured_mean * measured_mean;
    return is_exact && !std::isinf(variance) &&
           !(measured_variance - variance <= 2.5 * (measured_half_width + half_width) + rounding);
  }
};

/// The result of `compare`, and its texts.
struct Comparison {
  std::string problem;              ///< its name
  double integral = 0.0;            ///< by quadrature
  std::vector<ComparisonRow> rows;  ///< in the order of the contenders

  /// A table with one line for each contender, and one below for each whose mean is off or whose
  /// variance is larger than it says. Measured variances are marked with ~.
  [[nodiscard]] std::string text() const {
    std::size_t width = 10;
    for (const ComparisonRow& row : rows) width = std::max(width, row.name.size());
    char head[320];
    std::snprintf(head, sizeof(head), " %24s %10s %10s %12s %14s %12s %12s\n", "variance of a round", "ns", "densities",
                  "efficiency", "time to 10 %", "1 %", "0.1 %");
    std::string result =
        joined({problem, ": integral ", number(integral, "%.9g"), "\n", std::string(width, ' '), head});
    for (const ComparisonRow& row : rows) {
      std::string variance(row.is_exact ? "" : "~");
      variance += number(row.variance, "%.5g");
      if (row.half_width > 0.0) variance += joined({" ± ", number(row.half_width, "%.2g")});
      char line[320];
      std::snprintf(line, sizeof(line), " %24s %10.1f %10s %12.4g %14s %12s %12s\n", padded(variance, 24).c_str(),
                    row.nanoseconds,
                    std::isnan(row.density_evaluations) ? "" : number(row.density_evaluations, "%.4g").c_str(),
                    row.efficiency, time(row.seconds_to_1_percent / 100.0).c_str(),
                    time(row.seconds_to_1_percent).c_str(), time(row.seconds_to_1_percent * 100.0).c_str());
      result += joined({row.name, std::string(width - row.name.size(), ' '), line});
    }
    for (const ComparisonRow& row : rows) {
      constexpr std::string_view is_another = ": its variance and times are those of another estimator\n";
      if (row.has_wrong_exact_mean(integral)) {
        result += joined({row.name, ": mean ", number(*row.exact_mean, "%.6g"), is_another});
      } else if (row.has_wrong_mean(integral)) {
        result += joined({row.name, ": mean ", number(row.measured_mean, "%.6g"), ", standard error ",
                          number(row.mean_error, "%.2g"), is_another});
      } else if (row.has_wrong_variance()) {
        result += joined({row.name, ": measured variance ", number(row.measured_variance, "%.6g"), " ± ",
                          number(row.measured_half_width, "%.2g"), ": its variance and times are too small\n"});
      }
    }
    return result;
  }
  /// The rows as comma-separated values, with the names of the columns first.
  [[nodiscard]] std::string csv() const {
    std::string result;
    const auto add_line = [&](const auto& cells) {
      for (std::size_t i = 0; i < cells.size(); ++i) result += joined({i > 0 ? "," : "", cells[i]});
      result += "\n";
    };
    std::vector<std::string> names{"problem", "contender", "is_exact"};
    for (const Column& column : columns()) names.push_back(column.name);
    add_line(names);
    for (const ComparisonRow& row : rows) {
      std::vector<std::string> cells{quoted(problem, '"'), quoted(row.name, '"'), row.is_exact ? "1" : "0"};
      for (const Column& column : columns()) cells.push_back(number(column.value(row), "%.9g"));
      add_line(cells);
    }
    return result;
  }
  /// The comparison as a JSON object; a number that is not finite is null.
  [[nodiscard]] std::string json() const {
    const auto value = [](double x) { return std::isfinite(x) ? number(x, "%.9g") : std::string("null"); };
    std::string result =
        joined({"{\"problem\": ", quoted(problem, '\\'), ", \"integral\": ", value(integral), ", \"rows\": ["});
    for (std::size_t i = 0; i < rows.size(); ++i) {
      result += joined({i > 0 ? ",\n" : "\n", " {\"contender\": ", quoted(rows[i].name, '\\'),
                        ", \"is_exact\": ", rows[i].is_exact ? "true" : "false"});
      for (const Column& column : columns())
        result += joined({", \"", column.name, "\": ", value(column.value(rows[i]))});
      result += "}";
    }
    result += "\n]}\n";
    return result;
  }
  /// A program for gnuplot that draws the relative error of each contender over time as `svg_file`.
  /// An error that is 0 or not finite has no place on its axis, and is left out.
  [[nodiscard]] std::string gnuplot(const std::string& svg_file) const {
    std::string result =
        joined({"set terminal svg size 720,480 background 'white'\nset output ", quoted(svg_file, '\''),
                "\nset logscale xy\nset xlabel 'processor time [s]'\nset ylabel 'relative standard error'\nset title ",
                quoted(problem, '\''), "\nset key outside right\nset xrange [1e-5:1]\n"});
    const char* before = "plot ";
    for (const ComparisonRow& row : rows) {
      if (!(row.seconds_to_1_percent > 0.0 && std::isfinite(row.seconds_to_1_percent))) continue;
      result += joined({before, "sqrt(", number(row.seconds_to_1_percent, "%.9g"), "*1e-4/x) title ",
                        quoted(row.name, '\''), " linewidth 2"});
      before = ", \\\n  ";
    }
    result += "\n";
    return result;
  }

 private:
  struct Column {
    const char* name;
    double (*value)(const ComparisonRow&);
  };
  [[nodiscard]] static const std::vector<Column>& columns() {
    static const std::vector<Column> all{
        {"variance", [](const ComparisonRow& r) { return r.variance; }},
        {"variance_half_width", [](const ComparisonRow& r) { return r.half_width; }},
        {"measured_mean", [](const ComparisonRow& r) { return r.measured_mean; }},
        {"mean_error", [](const ComparisonRow& r) { return r.mean_error; }},
        {"measured_variance", [](const ComparisonRow& r) { return r.measured_variance; }},
        {"measured_half_width", [](const ComparisonRow& r) { return r.measured_half_width; }},
        {"measured_rounds", [](const ComparisonRow& r) { return static_cast<double>(r.measured_rounds); }},
        {"nanoseconds_per_round", [](const ComparisonRow& r) { return r.nanoseconds; }},
        {"density_evaluations", [](const ComparisonRow& r) { return r.density_evaluations; }},
        {"efficiency", [](const ComparisonRow& r) { return r.efficiency; }},
        {"seconds_to_10_percent", [](const ComparisonRow& r) { return r.seconds_to_1_percent / 100.0; }},
        {"seconds_to_1_percent", [](const ComparisonRow& r) { return r.seconds_to_1_percent; }},
        {"seconds_to_0.1_percent", [](const ComparisonRow& r) { return r.seconds_to_1_percent * 100.0; }}};
    return all;
  }
  // By appending alone: g++ 12 warns of overlapping memory in sums of literals and temporary
  // strings.
  [[nodiscard]] static std::string joined(std::initializer_list<std::string_view> pieces) {
    std::string result;
    for (const std::string_view piece : pieces) result += piece;
    return result;
  }
  [[nodiscard]] static std::string number(double value, const char* format) {
    char buffer[64];
    std::snprintf(buffer, sizeof(buffer), format, value);
    return buffer;
  }
  [[nodiscard]] static std::string time(double seconds) {
    if (!std::isfinite(seconds)) return "never";
    if (seconds < 1e-6) return number(seconds * 1e9, "%.3g ns");
    if (seconds < 1e-3) return number(seconds * 1e6, "%.3g us");
    if (seconds < 1.0) return number(seconds * 1e3, "%.3g ms");
    return number(seconds, "%.4g s");
  }
  // std::snprintf counts bytes, of which ± has two.
  [[nodiscard]] static std::string padded(const std::string& text, std::size_t width) {
    const std::size_t shown = text.size() - (text.find("±") != std::string::npos ? 1 : 0);
    std::string result(shown < width ? width - shown : 0, ' ');
    result += text;
    return result;
  }
  [[nodiscard]] static std::string quoted(const std::string& text, char escape) {
    const char quote = escape == '\'' ? '\'' : '"';
    std::string result(1, quote);
    for (const char letter : text) {
      const unsigned code = static_cast<unsigned char>(letter);
      if (escape != '"' && code < 0x20) {  // only CSV takes a tab or a new line as it is
        char escaped[8];
        std::snprintf(escaped, sizeof(escaped), "\\u%04x", code);
        result += escape == '\\' ? escaped : " ";
        continue;
      }
      if (letter == quote || (escape == '\\' && letter == '\\')) result += escape;
      result += letter;
    }
    result += quote;
    return result;
  }
};

/// Times and measures contenders side by side: the variance of a round, exact where the contender
/// has one and measured with its interval elsewhere; the processor time of a round, the least of
/// several slices that are interleaved in random order, so that a busy machine is fair to each;
/// what follows from both; and the densities of a round.
///
/// Throws std::invalid_argument for an integral of 0 (errors are relative to it), no contenders, an
/// exact variance that is negative or not a number, and settings that are not positive.
[[nodiscard]] inline Comparison compare(std::string problem, double integral, std::vector<Contender> contenders,
                                        const ComparisonSettings& settings = {}) {
  require_argument(integral != 0.0 && std::isfinite(integral), "errors are relative to the integral, which is 0 here");
  require_argument(!contenders.empty(), "give at least one contender to compare");
  for (const Contender& contender : contenders)
    require_argument(!contender.exact_variance || *contender.exact_variance >= 0.0,
                     "the exact variance of a contender is negative or not a number");
  require_argument(settings.slices > 0 && settings.slice_seconds > 0.0 && settings.measure_seconds > 0.0,
                   "a comparison needs at least one slice and positive times");
  const std::size_t count = contenders.size();
  std::vector<double> nanoseconds(count, std::numeric_limits<double>::infinity());
  std::vector<std::uint64_t> rounds_of_slice(count, 1);
  ComparisonSource source(settings.seed);
  double kept = 0.0;  // so that no round is optimised away
  const auto seconds_of = [&](std::size_t i) {
    const double start = settings.clock();
    kept += contenders[i].run(rounds_of_slice[i], {}, source).value;
    return settings.clock() - start;
  };
  for (std::size_t i = 0; i < count; ++i)
    for (double seconds = 0.0; rounds_of_slice[i] < std::uint64_t{1} << 40U;) {
      seconds = seconds_of(i);
      if (seconds >= settings.slice_seconds) break;
      const double missing = seconds > 0.0 ? 1.2 * settings.slice_seconds / seconds : 10.0;
      rounds_of_slice[i] = static_cast<std::uint64_t>(
          std::ceil(static_cast<double>(rounds_of_slice[i]) * std::clamp(missing, 1.1, 10.0)));
    }
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  for (int slice = 0; slice < settings.slices; ++slice) {
    for (std::size_t i = count; i > 1; --i)
      std::swap(order[i - 1], order[uniform_index(source, static_cast<std::uint32_t>(i))]);
    for (const std::size_t i : order)
      nanoseconds[i] = std::min(nanoseconds[i], seconds_of(i) * 1e9 / static_cast<double>(rounds_of_slice[i]));
  }

  Comparison comparison{std::move(problem), integral, {}};
  for (std::size_t i = 0; i < count; ++i) {
    ComparisonRow row;
    row.name = contenders[i].name;
    row.nanoseconds = nanoseconds[i];
    const double fit = settings.measure_seconds * 1e9 / std::max(nanoseconds[i], 1e-3);
    std::vector<double> values(static_cast<std::size_t>(std::clamp(fit, 400.0, 1e6)));
    ComparisonSource own(settings.seed + i + 1);
    const RoundValue sum = contenders[i].run(values.size(), values, own);
    const double n = static_cast<double>(values.size());
    row.measured_rounds = values.size();
    row.density_evaluations = sum.density_evaluations / n;
    row.measured_mean = sum.value / n;
    double squares = 0.0, fourths = 0.0;  // relative to the integral, for powers within the range of double
    for (const double value : values) {
      const double deviation = (value - row.measured_mean) / integral, square = deviation * deviation;
      squares += square / n;
      fourths += square * square / n;
    }
    constexpr double two_sided_95 = 1.959963984540054;
    row.measured_variance = squares * n / (n - 1.0) * integral * integral;
    row.measured_half_width =
        two_sided_95 * std::sqrt(std::max(0.0, fourths - squares * squares) / n) * integral * integral;
    row.mean_error = std::sqrt(squares / (n - 1.0)) * std::abs(integral);
    row.is_exact = contenders[i].exact_variance.has_value();
    row.exact_mean = contenders[i].exact_mean;
    row.variance = contenders[i].exact_variance.value_or(row.measured_variance);
    row.half_width = row.is_exact ? contenders[i].half_width : row.measured_half_width;
    const double seconds = row.nanoseconds * 1e-9;
    row.efficiency = ieee_divide(1.0, row.variance * seconds);
    row.seconds_to_1_percent = row.variance / integral / integral * seconds / 1e-4;
    comparison.rows.push_back(std::move(row));
  }
  if (std::isnan(kept)) comparison.problem += " (a round is not a number)";
  return comparison;
}

/// The same over a problem.
template <class Integrand, class P>
[[nodiscard]] Comparison compare(const ComparedProblem<Integrand, P>& problem, std::vector<Contender> contenders,
                                 const ComparisonSettings& settings = {}) {
  return compare(problem.name(), problem.integral(), std::move(contenders), settings);
}

}  // namespace gmis
