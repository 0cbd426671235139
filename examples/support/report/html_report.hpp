#pragma once

#include <filesystem>
#include <string>

#include "support/report/records.hpp"

namespace gmis::tools {

/// The whole report as one HTML page that needs nothing but itself. `folder` is for files of a
/// moment. Without gnuplot there are no curves in it, without libpng no images; the page says so.
[[nodiscard]] std::string html_of(const Comparison& comparison, const std::filesystem::path& folder);

}  // namespace gmis::tools
