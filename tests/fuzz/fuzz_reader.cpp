#include <cmath>
#include <string>
#include <string_view>

#include "fuzz/input.hpp"
#include "support/pbrt/reader.hpp"
#include "support/ply_mesh.hpp"

// The reader of scenes, and that of PLY meshes for an input that starts as one: whatever the bytes
// are, a scene or a mesh whose numbers hold together, or an InputError that names a place on one
// line.

namespace {

using namespace gmis::tools;

bool is_finite(const Point& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void check_mesh(const MeshDescription& mesh) {
  for (const Point& p : mesh.positions) fuzz::require(is_finite(p), "positions are numbers");
  fuzz::require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(),
                "one normal per position or none");
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle)
      fuzz::require(corner >= 0 && static_cast<std::size_t>(corner) < mesh.positions.size(), "corners are there");
}

void check_scene(const SceneDescription& scene) {
  fuzz::require(scene.film.width > 0 && scene.film.height > 0, "the film has pixels");
  for (const ShapeDescription& shape : scene.shapes) {
    fuzz::require(shape.material < scene.materials.size(), "materials are there");
    if (const auto* mesh = std::get_if<MeshDescription>(&shape.geometry)) check_mesh(*mesh);
    if (const auto* sphere = std::get_if<SphereDescription>(&shape.geometry))
      fuzz::require(is_finite(sphere->center) && sphere->radius > 0, "a sphere is one");
  }
}

void check_message(const InputError& error) {
  const std::string_view message = error.what();
  fuzz::require(!message.empty(), "an error says something");
  fuzz::require(message.find('\n') == std::string_view::npos, "an error is one line");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  Diagnostics diagnostics;
  try {
    if (text.starts_with("ply")) {
      LoadBudget budget(std::uintmax_t{64} << 20);
      check_mesh(parse_ply(text, "the mesh", budget, {}));
    } else {
      // No folder of that name: what a scene includes is not found.
      check_scene(read_pbrt_text(text, "input", "no-such-folder", diagnostics));
    }
  } catch (const InputError& error) {
    check_message(error);
  }
  return 0;
}
