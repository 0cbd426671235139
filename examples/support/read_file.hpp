#pragma once

#include <filesystem>
#include <string>

#include "support/load_budget.hpp"

namespace gmis::tools {

/// The bytes of a regular file, counted. `what` is what messages call it, such as "the mesh".
/// Throws `InputError` when it is missing, is a pipe, a device or a folder, cannot be read, or is
/// too large.
[[nodiscard]] std::string read_file(const std::filesystem::path& file, const std::string& what, LoadBudget& budget,
                                    const SourcePosition& where);

/// The bytes that a gzip file in memory unpacks to, counted as they come. Throws `InputError` when
/// it is not whole, and when this build has no zlib.
[[nodiscard]] std::string unpacked_gzip(const std::string& packed, const std::string& name, LoadBudget& budget,
                                        const SourcePosition& where);

}  // namespace gmis::tools
