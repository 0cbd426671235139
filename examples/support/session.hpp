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
/// the picture.
[[nodiscard]] RenderRequest request_of(const Options& options, const BuiltScene& scene);

/// Reads a reference and checks its size. One that is as large as the whole picture, or a whole
/// number of times as wide and high (it is then reduced to the means of blocks), is cut to the
/// crop.
[[nodiscard]] Image read_reference(const std::filesystem::path& file, const RenderRequest& request,
                                   glm::ivec2 resolution);

/// Set from now on by Ctrl-C, SIGTERM and SIGHUP; a second one ends the program at once.
[[nodiscard]] const std::atomic<bool>& interrupt_flag();

}  // namespace gmis::tools
