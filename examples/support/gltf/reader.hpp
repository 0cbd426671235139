#pragma once

#include <filesystem>

#include "support/load_options.hpp"
#include "support/scene_description.hpp"

/// \file
/// Reads glTF 2.0, as docs/scene-files.md describes it.

namespace gmis::tools {

/// True when this build can read glTF.
[[nodiscard]] bool can_read_gltf();

/// Reads a .gltf or .glb file. Unsupported features that change the picture, and the substitutes
/// for them, go to `diagnostics`. Throws `InputError` for a file that is not glTF 2.0 or is broken,
/// and when this build cannot read glTF.
[[nodiscard]] SceneDescription read_gltf_scene(const std::filesystem::path& file, Diagnostics& diagnostics,
                                               const LoadOptions& options = {});

/// The same from the bytes of such a file; other files are looked for beside `file`.
[[nodiscard]] SceneDescription read_gltf_bytes(std::string bytes, const std::filesystem::path& file,
                                               Diagnostics& diagnostics, const LoadOptions& options = {});

}  // namespace gmis::tools
