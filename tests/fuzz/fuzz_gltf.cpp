#include <cmath>
#include <string>
#include <string_view>

#include "fuzz/input.hpp"
#include "support/gltf/reader.hpp"

// The reader of glTF: whatever the bytes are, a scene whose numbers hold together, or an InputError
// of one line. There are no other files, and little memory.

namespace {

using namespace gmis::tools;

void check_shape(const ShapeDescription& shape, const SceneDescription& scene) {
  fuzz::require(shape.material < scene.materials.size(), "materials are there");
  const auto& mesh = std::get<MeshDescription>(shape.geometry);
  for (const Point& p : mesh.positions)
    fuzz::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are numbers");
  fuzz::require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(),
                "one normal per position or none");
  fuzz::require(mesh.uv.empty() || mesh.uv.size() == mesh.positions.size(), "one pair per position or none");
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle)
      fuzz::require(corner >= 0 && static_cast<std::size_t>(corner) < mesh.positions.size(), "corners are there");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const auto strictness : {Strictness::check, Strictness::lenient}) {
    Diagnostics diagnostics(strictness);
    LoadOptions options;
    options.max_memory = std::uintmax_t{64} << 20;
    options.seconds = 0.5;
    try {
      const SceneDescription scene = read_gltf_bytes(std::string(reinterpret_cast<const char*>(data), size),
                                                     "no-such-folder/input.gltf", diagnostics, options);
      for (const ShapeDescription& shape : scene.shapes) check_shape(shape, scene);
    } catch (const InputError& error) {
      fuzz::require(error.what()[0] != '\0', "an error says something");
      fuzz::require(std::string_view(error.what()).find('\n') == std::string_view::npos, "an error is one line");
    }
  }
  return 0;
}
