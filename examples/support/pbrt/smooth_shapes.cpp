#include "support/pbrt/smooth_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <utility>

namespace gmis::tools::pbrt {
namespace {

constexpr double pi = std::numbers::pi;

int steps_of(double degrees) {
  return std::max(1, static_cast<int>(std::ceil(128 * degrees / 360 - 1e-9)));
}

struct SurfaceVertex {
  Point position;
  glm::dvec3 normal;
};

/// A grid over (u, v) in [0, 1]²; the normal of a triangle is on the side of ∂p/∂u × ∂p/∂v.
/// Triangles without area at a pole are left out.
template <class At>
MeshDescription grid_mesh(int columns, int rows, bool has_normals, const At& at) {
  MeshDescription mesh;
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column) {
      const glm::dvec2 uv(static_cast<double>(column) / columns, static_cast<double>(row) / rows);
      const SurfaceVertex vertex = at(uv);
      mesh.positions.push_back(vertex.position);
      if (has_normals) mesh.normals.push_back(vertex.normal);
      mesh.uv.push_back(uv);
    }
  const auto add = [&](int a, int b, int c) {
    const auto p = [&](int i) { return mesh.positions[static_cast<std::size_t>(i)]; };
    const glm::dvec3 across = glm::cross(p(b) - p(a), p(c) - p(a));
    const double longest = std::max(glm::length(p(b) - p(a)), glm::length(p(c) - p(a)));
    if (glm::length(across) > 1e-12 * longest * longest) mesh.triangles.push_back({a, b, c});
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const int a = row * (columns + 1) + column, b = a + 1, c = b + columns + 1, d = c - 1;
      add(a, b, c);
      add(a, c, d);
    }
  return mesh;
}

}  // namespace

MeshDescription mesh_of(const DiskShape& disk) {
  const double phi_max = disk.phi_max * pi / 180;
  const int steps = steps_of(disk.phi_max);
  const double step = phi_max / steps;
  const double larger = std::sqrt(step / std::sin(step));  // a polygon of the same area
  return grid_mesh(steps, 1, false, [&](const glm::dvec2& uv) {
    // u runs around, v from the rim inwards: ∂p/∂u × ∂p/∂v points along z.
    const double radius = (disk.radius * (1 - uv.y) + disk.inner_radius * uv.y) * larger;
    const double phi = uv.x * phi_max;
    return SurfaceVertex{{radius * std::cos(phi), radius * std::sin(phi), disk.height}, {0, 0, 1}};
  });
}

MeshDescription mesh_of(const CylinderShape& cylinder) {
  const double phi_max = cylinder.phi_max * pi / 180;
  const int steps = steps_of(cylinder.phi_max);
  const double half_step = phi_max / steps / 2;
  const double radius = cylinder.radius * half_step / std::sin(half_step);
  return grid_mesh(steps, 1, true, [&](const glm::dvec2& uv) {
    const double phi = uv.x * phi_max;
    const glm::dvec3 outward(std::cos(phi), std::sin(phi), 0);
    return SurfaceVertex{outward * radius + glm::dvec3(0, 0, cylinder.z_min + (cylinder.z_max - cylinder.z_min) * uv.y),
                         outward};
  });
}

MeshDescription mesh_of(const PartialSphere& sphere) {
  const double phi_max = sphere.phi_max * pi / 180;
  const double from = std::acos(std::clamp(sphere.z_min / sphere.radius, -1.0, 1.0));
  const double to = std::acos(std::clamp(sphere.z_max / sphere.radius, -1.0, 1.0));
  const int rows = std::max(1, static_cast<int>(std::ceil(64 * (from - to) / pi - 1e-9)));
  return grid_mesh(steps_of(sphere.phi_max), rows, true, [&](const glm::dvec2& uv) {
    const double phi = uv.x * phi_max, theta = from + (to - from) * uv.y;
    const glm::dvec3 outward(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    return SurfaceVertex{outward * sphere.radius, outward};
  });
}

// ---- subdivision --------------------------------------------------------------------------------

namespace {

using Edge = std::pair<int, int>;

/// The vertices around each vertex, and which lie on a border.
struct Neighbours {
  std::vector<std::vector<int>> rings;          ///< all of them, in no order
  std::vector<std::array<int, 2>> border;       ///< the two along the border; −1: the vertex is within
  std::map<Edge, std::array<int, 2>> opposite;  ///< corners across an edge (smaller number first); −1: it is a border

  [[nodiscard]] bool is_border(std::size_t vertex) const { return border[vertex][0] >= 0; }
};

std::optional<Neighbours> neighbours_of(const MeshDescription& mesh) {
  Neighbours result;
  result.rings.resize(mesh.positions.size());
  result.border.assign(mesh.positions.size(), {-1, -1});
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangle[k], b = triangle[(k + 1) % 3], across = triangle[(k + 2) % 3];
      if (a == b) return {};
      // The first side is that of the triangle that runs from the smaller number to the larger.
      const Edge edge = std::minmax(a, b);
      auto [place, is_new] = result.opposite.try_emplace(edge, std::array{-1, -1});
      int& side = place->second[a < b ? 0 : 1];
      if (side >= 0) return {};
      side = across;
    }
  for (const auto& [edge, across] : result.opposite) {
    const auto a = static_cast<std::size_t>(edge.first), b = static_cast<std::size_t>(edge.second);
    result.rings[a].push_back(edge.second);
    result.rings[b].push_back(edge.first);
    if (across[0] >= 0 && across[1] >= 0) continue;
    for (const auto& [from, to] : {std::pair{a, edge.second}, std::pair{b, edge.first}}) {
      auto& ends = result.border[from];
      if (ends[1] >= 0) return {};  // two borders meet in a point
      ends[ends[0] < 0 ? 0 : 1] = to;
    }
  }
  return result;
}

/// Warren's choice of weights.
double ring_weight(std::size_t valence) {
  return valence == 3 ? 3.0 / 16 : 3.0 / (8 * static_cast<double>(valence));
}

/// `weight` of each neighbour, the rest of the vertex itself.
Point smoothed(const MeshDescription& mesh, const Neighbours& around, std::size_t vertex, double border_weight,
               double weight) {
  const auto at = [&](int i) { return mesh.positions[static_cast<std::size_t>(i)]; };
  const Point& here = mesh.positions[vertex];
  if (around.is_border(vertex)) {
    const auto& [a, b] = around.border[vertex];
    return here * (1 - 2 * border_weight) + (at(a) + at(b)) * border_weight;
  }
  Point sum(0);
  for (const int neighbour : around.rings[vertex]) sum += at(neighbour);
  return here * (1 - weight * static_cast<double>(around.rings[vertex].size())) + sum * weight;
}

MeshDescription subdivided_once(const MeshDescription& mesh, const Neighbours& around) {
  MeshDescription result;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    result.positions.push_back(around.rings[i].empty()
                                   ? mesh.positions[i]
                                   : smoothed(mesh, around, i, 1.0 / 8, ring_weight(around.rings[i].size())));
  std::map<Edge, int> middles;
  const auto at = [&](int i) { return mesh.positions[static_cast<std::size_t>(i)]; };
  for (const auto& [edge, across] : around.opposite) {
    const Point ends = at(edge.first) + at(edge.second);
    const bool is_border = across[0] < 0 || across[1] < 0;
    middles[edge] = static_cast<int>(result.positions.size());
    result.positions.push_back(is_border ? ends * 0.5 : ends * (3.0 / 8) + (at(across[0]) + at(across[1])) * (1.0 / 8));
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middles[std::minmax(a, b)], bc = middles[std::minmax(b, c)], ca = middles[std::minmax(c, a)];
    result.triangles.insert(result.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return result;
}

}  // namespace

std::optional<MeshDescription> loop_subdivided(const MeshDescription& mesh, int levels) {
  MeshDescription result;
  result.positions = mesh.positions;
  result.triangles = mesh.triangles;
  std::optional<Neighbours> around = neighbours_of(result);
  for (int level = 0; level < levels && around; ++level) {
    result = subdivided_once(result, *around);
    around = neighbours_of(result);
  }
  if (!around) return {};
  std::vector<Point> limit;
  for (std::size_t i = 0; i < result.positions.size(); ++i) {
    const std::size_t valence = around->rings[i].size();
    if (valence == 0) {
      limit.push_back(result.positions[i]);
      continue;
    }
    const double weight = 1 / (static_cast<double>(valence) + 3 / (8 * ring_weight(valence)));
    limit.push_back(smoothed(result, *around, i, 1.0 / 5, weight));
  }
  result.positions = std::move(limit);
  // Normals of the fine mesh, triangles weighted by area.
  result.normals.assign(result.positions.size(), glm::dvec3(0));
  for (const auto& triangle : result.triangles) {
    const auto p = [&](std::size_t k) { return result.positions[static_cast<std::size_t>(triangle[k])]; };
    const glm::dvec3 across = glm::cross(p(1) - p(0), p(2) - p(0));
    for (const int corner : triangle) result.normals[static_cast<std::size_t>(corner)] += across;
  }
  for (glm::dvec3& normal : result.normals) {
    const double length = glm::length(normal);
    normal = length > 0 ? normal / length : glm::dvec3(0, 0, 1);
  }
  return result;
}

}  // namespace gmis::tools::pbrt
