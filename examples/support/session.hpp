#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gmis/transport/plan/plan.hpp"
#include "support/render.hpp"
#include "support/statistics.hpp"

/// \file
/// The steps of gmis-render, one function each.

namespace gmis::tools {

/// The request that the options make for this scene. Throws `InputError` when the crop lies outside
/// the picture or --light-paths asks for too many light trees.
[[nodiscard]] RenderRequest request_of(const Options& options, const BuiltScene& scene);

/// Reads a reference, which has the size of the crop, of the whole picture, or of an integer
/// multiple of the whole picture. The last is reduced to the means of blocks; both of the latter
/// are cut to the crop. Throws `InputError` for any other size.
[[nodiscard]] Image read_reference(const std::filesystem::path& file, const RenderRequest& request,
                                   glm::ivec2 resolution);

/// Set from now on by Ctrl-C, SIGTERM and SIGHUP; a second one ends the program at once.
[[nodiscard]] const std::atomic<bool>& interrupt_flag();

}  // namespace gmis::tools
