#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "support/build_scene.hpp"
#include "support/diagnostics.hpp"
#include "support/load_options.hpp"

namespace gmis::tools {

/// A scene that is ready to be rendered, and how long that took.
struct LoadedScene {
  std::unique_ptr<BuiltScene> built;
  std::vector<Diagnostic> diagnostics;
  std::vector<std::filesystem::path> files;  ///< as in `SceneDescription`
  double read_seconds = 0;
  double build_seconds = 0;
};

/// `size` replaces that of the film.
[[nodiscard]] LoadedScene load_scene(const std::filesystem::path& file, std::optional<std::array<int, 2>> size,
                                     Strictness strictness = Strictness::strict,
                                     scene::LightSelection lights = scene::LightSelection::by_power,
                                     const LoadOptions& options = {});

/// Reads the scene and builds nothing: all that there is to say of it, errors included.
[[nodiscard]] Diagnostics check_scene_file(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace gmis::tools
