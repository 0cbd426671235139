#pragma once

#include <filesystem>

#include "support/load_options.hpp"
#include "support/scene_description.hpp"

namespace gmis::tools {

/// True for a name that ends in .gltf or .glb.
[[nodiscard]] bool is_gltf(const std::filesystem::path& file);

/// Reads a scene by the ending of its name: .gltf and .glb, else pbrt's text.
[[nodiscard]] SceneDescription read_scene(const std::filesystem::path& file, Diagnostics& diagnostics,
                                          const LoadOptions& options = {});

}  // namespace gmis::tools
