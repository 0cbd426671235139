#include "support/report/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace gmis::tools {

namespace {

/// Characters as a terminal shows them: bytes that continue one are not counted.
std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string seconds_text(const TimeToError& time, std::size_t seeds) {
  if (time.seconds) return three_digits(*time.seconds) + " s";
  std::string text = "not reached";
  if (time.reached > 0) text += " by " + std::to_string(seeds - time.reached) + " of " + std::to_string(seeds);
  if (time.predicted) text += " (≈ " + three_digits(*time.predicted) + " s)";
  return text;
}

std::string efficiency_text(const std::optional<Interval>& efficiency, bool is_baseline) {
  if (is_baseline) return "1";
  if (!efficiency) return "–";
  const std::string text = three_digits(efficiency->value);
  if (!std::isfinite(efficiency->upper)) return text + " (too few seeds)";
  return text + " (" + three_digits(efficiency->lower) + " to " + three_digits(efficiency->upper) + ")";
}

/// A round target as it is spoken of: 5 %, 0.2 %.
std::string percent_of(double target) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g %%", 100 * target);
  return buffer;
}

std::string bias_text(const ContenderRecord& contender) {
  if (!contender.is_merging) return "none";
  if (!contender.bias) return "not measured";
  const MergingBias& bias = *contender.bias;
  if (bias.relative_bias == 0 && bias.standard_error == 0) return "none";  // nothing was merged
  if (bias.relative_bias <= 2 * bias.standard_error) return "below " + percentage(2 * bias.standard_error);
  return percentage(bias.relative_bias);
}

}  // namespace

std::string three_digits(double value) {
  if (!std::isfinite(value)) return value > 0 ? "∞" : "–";
  if (value == 0) return "0";
  const int before_point = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  char buffer[64];
  const double unit = std::pow(10.0, std::max(0, before_point - 3));
  if (unit > 1) value = unit * std::round(value / unit);
  std::snprintf(buffer, sizeof buffer, "%.*f", std::clamp(3 - before_point, 0, 12), value);
  return buffer;
}

std::string percentage(double value) {
  return three_digits(100 * value) + " %";
}

std::string reference_warning(const SceneRecord& scene) {
  std::optional<double> smallest;
  for (const ContenderRecord& contender : scene.contenders)
    if (const auto error = last_error(contender.courses())) smallest = std::min(smallest.value_or(*error), *error);
  if (!scene.reference_error || !smallest || 3 * *scene.reference_error < *smallest) return {};
  return " This is not small against the errors below, which include it: the true errors are smaller.";
}

Table table_of(const SceneRecord& scene) {
  Table table;
  table.headings = {"integrator", "iterations", "error at the end"};
  std::vector<Courses> all;
  for (const ContenderRecord& contender : scene.contenders) all.push_back(contender.courses());
  const std::array<double, 3> targets = targets_of(all);
  for (const double target : targets) table.headings.push_back("to " + percent_of(target));
  table.headings.insert(table.headings.end(), {"efficiency, vcm = 1", "slope", "merging bias"});
  const ContenderRecord* baseline = baseline_of(scene);
  const Courses baseline_courses = baseline != nullptr ? baseline->courses() : Courses{};
  for (const ContenderRecord& contender : scene.contenders) {
    const Courses courses = contender.courses();
    double iterations = 0;
    for (const RunRecord& run : contender.runs)
      iterations += static_cast<double>(run.iterations) / static_cast<double>(contender.runs.size());
    std::vector<std::string> row{contender.name, std::to_string(std::lround(iterations))};
    const auto error = last_error(courses);
    row.push_back(error ? percentage(*error) : "–");
    for (const double target : targets) row.push_back(seconds_text(time_to_error(courses, target), courses.size()));
    row.push_back(efficiency_text(relative_efficiency(courses, baseline_courses), &contender == baseline));
    const auto slope = mean_slope(courses);
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.2f", slope.value_or(0));
    row.push_back(slope ? buffer : "–");
    row.push_back(bias_text(contender));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table metrics_table_of(const SceneRecord& scene) {
  Table table;
  table.headings = {"integrator", "relative error", "without the worst 0.1 %", "SMAPE", "ꟻLIP"};
  for (const ContenderRecord& contender : scene.contenders) {
    if (!contender.picture_error) continue;
    const ImageMetrics& metrics = contender.picture_error->metrics;
    table.rows.push_back({contender.name, percentage(metrics.relative_error), percentage(metrics.trimmed),
                          percentage(metrics.smape), percentage(metrics.flip)});
  }
  return table;
}

std::string markdown_of(const Comparison& comparison) {
  std::string text;
  for (const SceneRecord& scene : comparison.scenes) {
    const Table table = table_of(scene);
    text += "### " + scene.name + "\n\n";
    const auto add_row = [&](const std::vector<std::string>& cells) {
      for (const std::string& cell : cells) text += "| " + cell + " ";
      text += "|\n";
    };
    add_row(table.headings);
    add_row(std::vector<std::string>(table.headings.size(), "---"));
    for (const auto& row : table.rows) add_row(row);
    if (const Table metrics = metrics_table_of(scene); !metrics.rows.empty()) {
      text += "\nThe pictures of the first seed, at the end:\n\n";
      add_row(metrics.headings);
      add_row(std::vector<std::string>(metrics.headings.size(), "---"));
      for (const auto& row : metrics.rows) add_row(row);
    }
    text += "\nReference: " + scene.reference_origin + "." + reference_warning(scene) + "\n\n";
  }
  text += comparison.limits + "; " + comparison.settings + "; " + comparison.machine + ".\n";
  if (!comparison.is_whole) text += "Interrupted: not all runs are whole.\n";
  return text;
}

std::string text_of(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t column = 0; column < table.headings.size(); ++column) {
    widths.push_back(shown_width(table.headings[column]));
    for (const auto& row : table.rows) widths.back() = std::max(widths.back(), shown_width(row[column]));
  }
  std::string text;
  const auto add_row = [&](const std::vector<std::string>& cells) {
    for (std::size_t column = 0; column < cells.size(); ++column) {
      const std::string padding(widths[column] - shown_width(cells[column]), ' ');
      text += column == 0 ? cells[column] + padding : "  " + padding + cells[column];
    }
    text += "\n";
  };
  add_row(table.headings);
  for (const auto& row : table.rows) add_row(row);
  return text;
}

}  // namespace gmis::tools
