#pragma once

#include <filesystem>
#include <string>

#include "support/load_options.hpp"
#include "support/scene_description.hpp"

/// \file
/// Reads the subset of pbrt-v4's scene format that docs/scene-files.md describes.

namespace gmis::tools {

/// Reads the scene in `file`. What was ignored goes to `diagnostics`. Throws `InputError`, whose
/// message starts with `file:line:`, for what cannot be read or is not understood.
[[nodiscard]] SceneDescription read_pbrt_scene(const std::filesystem::path& file, Diagnostics& diagnostics,
                                               const LoadOptions& options = {});

/// The same from text in memory; `name` stands for the file in messages, `folder` is where its
/// other files are.
[[nodiscard]] SceneDescription read_pbrt_text(const std::string& text, const std::string& name,
                                              const std::filesystem::path& folder, Diagnostics& diagnostics,
                                              const LoadOptions& options = {});

}  // namespace gmis::tools
