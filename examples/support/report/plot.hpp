#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/report/records.hpp"

namespace gmis::tools {

/// Is gnuplot on this machine?
[[nodiscard]] bool has_gnuplot();

/// Error over processor time of all integrators of a scene, both axes logarithmic, with a band from
/// the lowest to the highest seed, as an SVG element to be put into a page: the lines take their
/// colours from the page's `--series-1`, `--series-2`, …, the axes from `--axis`. Uses files in
/// `folder`, which are gone afterwards. Empty when there is nothing to show or gnuplot fails.
[[nodiscard]] std::string error_plot_svg(const SceneRecord& scene, const std::filesystem::path& folder);

/// The plots of all scenes in one picture, two beside each other, each with its name above it: a
/// file that needs no page, with colours for a light and a dark background. Empty when no scene has
/// a plot.
[[nodiscard]] std::string error_figure_svg(const std::vector<SceneRecord>& scenes, const std::filesystem::path& folder);

}  // namespace gmis::tools
