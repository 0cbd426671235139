#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Light that a surface emits: `radiance` from the side of the geometric normal, or from both.
struct AreaEmission {
  glm::dvec3 radiance{1};     ///< per steradian and projected area
  bool is_two_sided = false;  ///< else on the side of the normal alone
};

/// Triangles with shared corners, in world coordinates. The geometric normal of a triangle is (b −
/// a) × (c − a).
struct MeshShape {
  std::span<const glm::dvec3> positions;          ///< corners, in world space
  std::span<const std::array<int, 3>> triangles;  ///< three numbers of corners each
  std::span<const glm::dvec3> normals{};          ///< for shading, one per position; or none, and the mesh is flat
  std::span<const glm::dvec2> uv{};               ///< for textures, one per position; or none: (0, 0), (1, 0), (1, 1)
};

/// Throws std::invalid_argument for a place of the world that is not finite, or beyond 1e100.
inline void check_place(const glm::dvec3& v) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(std::abs(v[axis]) < 1e100)) reject_argument("a coordinate is not finite or too large");
}

/// Throws std::invalid_argument for a mesh whose numbers do not fit together.
inline void check_mesh(const MeshShape& mesh) {
  for (const glm::dvec3& position : mesh.positions) check_place(position);
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
    reject_argument("a mesh needs as many normals as positions, or none");
  for (const glm::dvec3& normal : mesh.normals) check_place(normal);
  if (!mesh.uv.empty() && mesh.uv.size() != mesh.positions.size())
    reject_argument("a mesh needs as many coordinates (u, v) as positions, or none");
  for (const glm::dvec2& uv : mesh.uv) check_place(glm::dvec3(uv, 0));
  for (const auto& triangle : mesh.triangles)
    for (const int index : triangle)
      if (index < 0 || static_cast<std::size_t>(index) >= mesh.positions.size()) {
        const std::string what = "a triangle refers to corner " + std::to_string(index) + " of a mesh with " +
                                 std::to_string(mesh.positions.size()) + " positions";
        reject_argument(what.c_str());
      }
}

}  // namespace gmis::scene
