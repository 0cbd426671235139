#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "support/pbrt/elements.hpp"
#include "support/pbrt/smooth_shapes.hpp"
#include "support/ply_mesh.hpp"

namespace gmis::tools::pbrt {
namespace {

/// A turn, or part of one.
double phi_max_of(Parameters& parameters) {
  const double phi_max = parameters.number_or("phimax", 360);
  if (!(phi_max > 0)) parameters.fail("phimax", "must be above 0");
  return std::min(phi_max, 360.0);
}

double radius_of(Parameters& parameters) {
  const double radius = parameters.number_or("radius", 1);
  if (!(radius > 0)) parameters.fail("radius", "must be above 0");
  return radius;
}

std::variant<MeshDescription, SphereDescription> make_sphere(Parameters& parameters) {
  PartialSphere sphere;
  sphere.radius = radius_of(parameters);
  sphere.z_min = std::max(parameters.number_or("zmin", -sphere.radius), -sphere.radius);
  sphere.z_max = std::min(parameters.number_or("zmax", sphere.radius), sphere.radius);
  sphere.phi_max = phi_max_of(parameters);
  if (!(sphere.z_min < sphere.z_max)) parameters.fail("zmin", "must be below zmax");
  if (sphere.z_min > -sphere.radius || sphere.z_max < sphere.radius || sphere.phi_max < 360) return mesh_of(sphere);
  SphereDescription full;
  full.radius = sphere.radius;
  return full;
}

MeshDescription make_disk(Parameters& parameters) {
  DiskShape disk;
  disk.height = parameters.number_or("height", 0);
  disk.radius = radius_of(parameters);
  disk.inner_radius = parameters.number_or("innerradius", 0);
  if (!(disk.inner_radius >= 0 && disk.inner_radius < disk.radius))
    parameters.fail("innerradius", "must be from 0 to below the radius");
  disk.phi_max = phi_max_of(parameters);
  return mesh_of(disk);
}

MeshDescription make_cylinder(Parameters& parameters) {
  CylinderShape cylinder;
  cylinder.radius = radius_of(parameters);
  cylinder.z_min = parameters.number_or("zmin", -1);
  cylinder.z_max = parameters.number_or("zmax", 1);
  if (!(cylinder.z_min < cylinder.z_max)) parameters.fail("zmin", "must be below zmax");
  cylinder.phi_max = phi_max_of(parameters);
  return mesh_of(cylinder);
}

/// Indices in groups of `corners`; when there are none and one group's worth of positions, these in
/// order.
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

/// The points of a mesh, without its faces.
MeshDescription points_of(Parameters& parameters) {
  MeshDescription mesh;
  mesh.positions = parameters.points("P");
  if (mesh.positions.empty()) throw InputError(parameters.where(), parameters.directive() + ": add \"point3 P\"");
  return mesh;
}

/// The points of a mesh, and its triangles.
MeshDescription triangles_of(Parameters& parameters) {
  MeshDescription mesh = points_of(parameters);
  const std::vector<int> indices = checked_indices(parameters, mesh.positions.size(), 3);
  for (std::size_t i = 0; i < indices.size(); i += 3)
    mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return mesh;
}

MeshDescription make_triangle_mesh(Parameters& parameters) {
  MeshDescription mesh = triangles_of(parameters);
  mesh.normals = parameters.normals("N");
  mesh.uv = parameters.pairs(parameters.has("uv") ? "uv" : "st");
  return mesh;
}

MeshDescription make_loop_subdivision(Parameters& parameters, const LoadBudget& budget) {
  const MeshDescription mesh = triangles_of(parameters);
  const int levels = parameters.integer("levels").value_or(3);
  if (levels < 0 || levels > 10) parameters.fail("levels", "must be from 0 to 10");
  if (mesh.triangles.size() > std::size_t{200'000'000} >> (2 * levels))
    parameters.fail("levels", "would make more than 200 million triangles");
  LoadBudget room = budget;  // the shape is counted where it is placed
  room.take(mesh.triangles.size() << (2 * levels), bytes_of_triangle, "the subdivided mesh", parameters.where());
  parameters.ignore({"scheme"});
  auto result = loop_subdivided(mesh, levels);
  if (!result)
    parameters.fail(
        "indices",
        "has an edge with more than two triangles, a vertex where two borders meet, a triangle that names a vertex "
        "twice, or neighbours that are turned differently");
  return std::move(*result);
}

MeshDescription make_bilinear_mesh(Parameters& parameters, Diagnostics& diagnostics) {
  MeshDescription mesh = points_of(parameters);
  const std::vector<int> indices = checked_indices(parameters, mesh.positions.size(), 4);
  for (std::size_t i = 0; i < indices.size(); i += 4) {
    // The corners come as (u, v) = (0,0) (1,0) (0,1) (1,1); the patch's side is that of ∂p/∂u ×
    // ∂p/∂v.
    const std::array corner{indices[i], indices[i + 1], indices[i + 2], indices[i + 3]};
    mesh.triangles.push_back({corner[0], corner[1], corner[3]});
    mesh.triangles.push_back({corner[0], corner[3], corner[2]});
    if (!parameters.has("uv")) {
      // The corners of the patch are those of the unit square; vertices that patches share are not
      // told apart.
      mesh.uv.resize(mesh.positions.size());
      for (std::size_t k = 0; k < 4; ++k)
        mesh.uv[static_cast<std::size_t>(corner[k])] = {static_cast<double>(k % 2), static_cast<double>(k / 2)};
    }
    const auto at = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(corner[k])]; };
    const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
    const double size = std::sqrt(glm::length(normal));
    if (std::abs(glm::dot(normal, at(3) - at(0))) > 1e-4 * size * glm::length(normal))
      diagnostics.warning(parameters.where(), "a bilinear patch that is not flat becomes two triangles");
  }
  mesh.normals = parameters.normals("N");
  if (parameters.has("uv")) mesh.uv = parameters.pairs("uv");
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
                                           const Files& files, Diagnostics& diagnostics) {
  ShapeDescription shape;
  shape.where = parameters.where();
  if (const auto alpha = parameters.number_texture("alpha");
      alpha && !((*alpha)->is_constant() && (*alpha)->mean().x >= 1))
    shape.opacity = *alpha;
  parameters.ignore({"shadowalpha"});
  if (kind == "sphere") {
    shape.geometry = make_sphere(parameters);
  } else if (kind == "trianglemesh") {
    shape.geometry = make_triangle_mesh(parameters);
  } else if (kind == "bilinearmesh") {
    shape.geometry = make_bilinear_mesh(parameters, diagnostics);
  } else if (kind == "disk") {
    shape.geometry = make_disk(parameters);
  } else if (kind == "cylinder") {
    shape.geometry = make_cylinder(parameters);
  } else if (kind == "loopsubdiv") {
    shape.geometry = make_loop_subdivision(parameters, *files.budget);
  } else if (kind == "plymesh") {
    const std::optional<std::string> file = parameters.string("filename");
    if (!file) throw InputError(parameters.where(), parameters.directive() + ": add \"string filename\"");
    if (parameters.has("displacement")) {
      parameters.unsupported("displacement", "is not supported: the mesh stays as it is without it", diagnostics);
      parameters.ignore({"displacement", "displacement.edgelength", "displacement.uvscale"});
    }
    parameters.ignore({"edgelength"});
    try {
      shape.geometry = read_ply(files.find(*file), *files.budget, parameters.where());
    } catch (const InputError& error) {
      diagnostics.unsupported(parameters.where(), error.message());  // the mesh is left out with --lenient
      return {};
    }
  } else {
    diagnostics.unsupported(parameters.where(),
                            "the shape " + in_quotes(kind) +
                                " is not understood: use sphere, disk, cylinder, trianglemesh, plymesh, bilinearmesh "
                                "or loopsubdiv");
    parameters.ignore_all();
    return {};
  }
  if (auto* sphere = std::get_if<SphereDescription>(&shape.geometry)) {
    sphere->normal_points_inward = reverse_orientation;
    return shape;
  }
  auto& mesh = std::get<MeshDescription>(shape.geometry);
  parameters.ignore({"uv", "st", "S", "faceIndices"});
  check_normals(mesh, parameters, diagnostics);
  if (!mesh.uv.empty() && mesh.uv.size() != mesh.positions.size())
    parameters.fail("uv", "has " + std::to_string(mesh.uv.size()) + " pairs for " +
                              std::to_string(mesh.positions.size()) + " points: give one each");
  for (const glm::dvec2& uv : mesh.uv)
    if (!(std::abs(uv.x) < 1e9 && std::abs(uv.y) < 1e9)) parameters.fail("uv", "has a value that is not below 1e9");
  if (reverse_orientation) {
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    for (glm::dvec3& n : mesh.normals) n = -n;
  }
  return shape;
}

}  // namespace gmis::tools::pbrt
