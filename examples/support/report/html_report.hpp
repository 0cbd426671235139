#pragma once

#include <filesystem>
#include <string>

#include "support/report/records.hpp"

namespace gmis::tools {

/// The whole report as one HTML page that needs nothing but itself. Temporary files go to
/// `folder`. Without gnuplot there are no curves in it, without libpng no error maps; the page says
/// so.
[[nodiscard]] std::string html_of(const Comparison& comparison, const std::filesystem::path& folder);

}  // namespace gmis::tools
