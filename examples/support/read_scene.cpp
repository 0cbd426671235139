#include "support/read_scene.hpp"

#include "support/gltf/reader.hpp"
#include "support/pbrt/reader.hpp"

namespace gmis::tools {

SceneDescription read_scene(const std::filesystem::path& file, Diagnostics& diagnostics) {
  const std::filesystem::path ending = file.extension();
  return ending == ".gltf" || ending == ".glb" ? read_gltf_scene(file, diagnostics)
                                               : read_pbrt_scene(file, diagnostics);
}

}  // namespace gmis::tools
