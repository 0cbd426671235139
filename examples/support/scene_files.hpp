#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/diagnostics.hpp"

namespace gmis::tools {

/// The folder of the built-in scenes: where it was when this program was built, or else beside the
/// program.
[[nodiscard]] std::filesystem::path built_in_scene_folder();
[[nodiscard]] std::vector<std::string> built_in_scene_names();
/// The description of a built-in scene: the comment in its first line.
[[nodiscard]] std::string line_of_scene(const std::string& name);

/// The file that SCENE on the command line means. Throws `InputError` when there is none.
[[nodiscard]] std::filesystem::path find_scene(const std::string& name);

}  // namespace gmis::tools
