#include "support/read_scene.hpp"

#include <algorithm>
#include <cctype>

#include "support/gltf/reader.hpp"
#include "support/pbrt/reader.hpp"
#include "support/sky.hpp"

namespace gmis::tools {

bool is_gltf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".gltf" || ending == ".glb";
}

SceneDescription read_scene(const std::filesystem::path& file, Diagnostics& diagnostics, const LoadOptions& options) {
  SceneDescription scene =
      is_gltf(file) ? read_gltf_scene(file, diagnostics, options) : read_pbrt_scene(file, diagnostics, options);
  if (!options.sky.empty()) replace_sky(scene, options.sky);
  return scene;
}

}  // namespace gmis::tools
