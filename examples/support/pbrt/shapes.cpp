#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "support/pbrt/elements.hpp"
#include "support/ply_mesh.hpp"

namespace gmis::tools::pbrt {
namespace {

SphereDescription make_sphere(Parameters& parameters) {
  SphereDescription sphere;
  sphere.radius = parameters.number_or("radius", 1);
  if (!(sphere.radius > 0)) parameters.fail("radius", "must be above 0");
  const bool is_full = parameters.number_or("zmin", -sphere.radius) <= -sphere.radius &&
                       parameters.number_or("zmax", sphere.radius) >= sphere.radius &&
                       parameters.number_or("phimax", 360) >= 360;
  if (!is_full)
    throw InputError(parameters.where(), "only full spheres are supported: leave out zmin, zmax and phimax");
  return sphere;
}

/// Indices in groups of `corners`; when there are none and one group's worth of positions, these in order.
std::vector<int> checked_indices(Parameters& parameters, std::size_t positions, std::size_t corners) {
  std::vector<int> indices = parameters.integers("indices");
  if (indices.empty()) {
    if (positions != corners)
      throw InputError(parameters.where(), parameters.directive() + ": add \"integer indices\"");
    for (std::size_t i = 0; i < corners; ++i) indices.push_back(static_cast<int>(i));
  }
  if (indices.size() % corners != 0)
    parameters.fail("indices", "has " + std::to_string(indices.size()) + " numbers: they must come in groups of " +
                                   std::to_string(corners));
  for (const int index : indices)
    if (index < 0 || static_cast<std::size_t>(index) >= positions)
      parameters.fail("indices", "holds " + std::to_string(index) + ", but there are only " +
                                     std::to_string(positions) + " points in P");
  return indices;
}

MeshDescription make_triangle_mesh(Parameters& parameters) {
  MeshDescription mesh;
  mesh.positions = parameters.points("P");
  if (mesh.positions.empty()) throw InputError(parameters.where(), parameters.directive() + ": add \"point3 P\"");
  const std::vector<int> indices = checked_indices(parameters, mesh.positions.size(), 3);
  for (std::size_t i = 0; i < indices.size(); i += 3)
    mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  mesh.normals = parameters.normals("N");
  return mesh;
}

MeshDescription make_bilinear_mesh(Parameters& parameters, Diagnostics& diagnostics) {
  MeshDescription mesh;
  mesh.positions = parameters.points("P");
  if (mesh.positions.empty()) throw InputError(parameters.where(), parameters.directive() + ": add \"point3 P\"");
  const std::vector<int> indices = checked_indices(parameters, mesh.positions.size(), 4);
  for (std::size_t i = 0; i < indices.size(); i += 4) {
    // The corners come as (u, v) = (0,0) (1,0) (0,1) (1,1); the patch's side is that of ∂p/∂u × ∂p/∂v.
    const std::array corner{indices[i], indices[i + 1], indices[i + 2], indices[i + 3]};
    mesh.triangles.push_back({corner[0], corner[1], corner[3]});
    mesh.triangles.push_back({corner[0], corner[3], corner[2]});
    const auto at = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(corner[k])]; };
    const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
    const double size = std::sqrt(glm::length(normal));
    if (std::abs(glm::dot(normal, at(3) - at(0))) > 1e-4 * size * glm::length(normal))
      diagnostics.warning(parameters.where(), "a bilinear patch that is not flat becomes two triangles");
  }
  mesh.normals = parameters.normals("N");
  return mesh;
}

void check_normals(MeshDescription& mesh, const Parameters& parameters, Diagnostics& diagnostics) {
  if (mesh.normals.empty()) return;
  if (mesh.normals.size() != mesh.positions.size())
    parameters.fail("N", "has " + std::to_string(mesh.normals.size()) + " normals for " +
                             std::to_string(mesh.positions.size()) + " points: give one each");
  for (glm::dvec3& n : mesh.normals) {
    const double length = glm::length(n);
    if (!(length > 0) || !std::isfinite(length)) {
      diagnostics.warning(parameters.where(),
                          parameters.directive() + ": a normal of length zero; the mesh is shown with flat triangles");
      mesh.normals.clear();
      return;
    }
    n /= length;
  }
}

}  // namespace

std::optional<ShapeDescription> make_shape(const std::string& kind, Parameters& parameters, bool reverse_orientation,
                                           const std::filesystem::path& folder, Diagnostics& diagnostics) {
  ShapeDescription shape;
  shape.where = parameters.where();
  if (parameters.has("alpha") && parameters.number("alpha") != 1.0)
    parameters.fail("alpha", "is not supported: surfaces are opaque or absent");
  if (kind == "sphere") {
    SphereDescription sphere = make_sphere(parameters);
    sphere.normal_points_inward = reverse_orientation;
    shape.geometry = sphere;
    return shape;
  }
  MeshDescription mesh;
  if (kind == "trianglemesh") {
    mesh = make_triangle_mesh(parameters);
  } else if (kind == "bilinearmesh") {
    mesh = make_bilinear_mesh(parameters, diagnostics);
  } else if (kind == "plymesh") {
    const std::optional<std::string> file = parameters.string("filename");
    if (!file) throw InputError(parameters.where(), parameters.directive() + ": add \"string filename\"");
    mesh = read_ply(folder / *file, parameters.where());
    parameters.ignore({"edgelength"});
  } else {
    diagnostics.unsupported(
        parameters.where(),
        "the shape " + in_quotes(kind) + " is not understood: use sphere, trianglemesh, plymesh or bilinearmesh");
    parameters.ignore_all();
    return {};
  }
  parameters.ignore({"uv", "S", "faceIndices"});
  check_normals(mesh, parameters, diagnostics);
  if (reverse_orientation) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    for (glm::dvec3& n : mesh.normals) n = -n;
  }
  shape.geometry = std::move(mesh);
  return shape;
}

}  // namespace gmis::tools::pbrt
