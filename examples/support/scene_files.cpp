#include "support/scene_files.hpp"

#include <algorithm>
#include <fstream>

namespace gmis::tools {
namespace fs = std::filesystem;

fs::path built_in_scene_folder() {
  std::error_code error;
  const fs::path when_built = GMIS_SCENE_FOLDER;
  if (fs::is_directory(when_built, error)) return when_built;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* relative : {"scenes", "../share/gmis/scenes", "../../../examples/scenes"})
    if (fs::is_directory(program / relative, error)) return program / relative;
  return when_built;
}

std::vector<std::string> built_in_scene_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(built_in_scene_folder(), error))
    if (entry.path().extension() == ".pbrt") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string line_of_scene(const std::string& name) {
  std::ifstream stream(built_in_scene_folder() / (name + ".pbrt"));
  std::string line;
  std::getline(stream, line);
  return line.starts_with("# ") ? line.substr(2) : "";
}

fs::path find_scene(const std::string& name) {
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  const bool is_plain_name = name.find('/') == std::string::npos;
  if (is_plain_name) {
    const fs::path file = built_in_scene_folder() / (fs::path(name).extension() == ".pbrt" ? name : name + ".pbrt");
    if (fs::is_regular_file(file, error)) return file;
  }
  throw InputError(name + ": there is no such file and no built-in scene of that name: see gmis-render --list-scenes");
}

}  // namespace gmis::tools
