#pragma once

#include <string>
#include <vector>

#include "support/report/records.hpp"

namespace gmis::tools {

/// One row per integrator, as text: what the report, the terminal and the documents show.
struct Table {
  std::vector<std::string> headings;
  std::vector<std::vector<std::string>> rows;
};

/// Integrator, iterations, error at the end, seconds to reach each of `targets_of` ("not reached"
/// where a seed missed it), efficiency relative to the baseline with its interval, slope, merging's
/// bias.
[[nodiscard]] Table table_of(const SceneRecord& scene);

/// One row per integrator: the picture of its first seed at the end against the reference, by four
/// measures (metrics.hpp). No rows without a reference.
[[nodiscard]] Table metrics_table_of(const SceneRecord& scene);

/// A sentence (with a space before it) when the reference's own noise is more than a third of the
/// smallest error.
[[nodiscard]] std::string reference_warning(const SceneRecord& scene);

/// The tables of all scenes, as Markdown.
[[nodiscard]] std::string markdown_of(const Comparison& comparison);
/// The table of one scene, for a terminal.
[[nodiscard]] std::string text_of(const Table& table);

/// Three significant digits without an exponent: 1230, 12.3, 0.0123.
[[nodiscard]] std::string three_digits(double value);
/// The value as a percentage.
[[nodiscard]] std::string percentage(double value);

}  // namespace gmis::tools
