#include "support/read_scene.hpp"

#include <string>

#include "support/file_ending.hpp"
#include "support/gltf/reader.hpp"
#include "support/pbrt/reader.hpp"
#include "support/sky.hpp"

namespace gmis::tools {

bool is_gltf(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".gltf" || ending == ".glb";
}

SceneDescription read_scene(const std::filesystem::path& file, Diagnostics& diagnostics, const LoadOptions& options) {
  SceneDescription scene =
      is_gltf(file) ? read_gltf_scene(file, diagnostics, options) : read_pbrt_scene(file, diagnostics, options);
  if (!options.sky.empty()) replace_sky(scene, options.sky);
  return scene;
}

}  // namespace gmis::tools
