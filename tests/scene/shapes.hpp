#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene.hpp"

namespace scene_test {

using gmis::Philox;
using gmis::uniform;
using gmis::Vec2;
using gmis::Vec3;

struct Mesh {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<int, 3>> triangles;
  [[nodiscard]] gmis::scene::MeshShape shape() const { return {positions, triangles, {}}; }
};

/// A closed box with outward normals.
inline Mesh box(const glm::dvec3& lower, const glm::dvec3& upper) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(
        {(i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y, (i & 4) != 0 ? upper.z : lower.z});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A closed, star-shaped surface around `center`, its vertices at random distances: all edges are
/// shared by two triangles.
inline Mesh bumpy_ball(const glm::dvec3& center, double radius, int rows, Philox& source) {
  Mesh mesh;
  const int columns = 2 * rows;
  mesh.positions.push_back(center + glm::dvec3(0, 0, radius));
  mesh.positions.push_back(center - glm::dvec3(0, 0, radius));
  for (int row = 1; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double theta = gmis::pi<double> * row / rows, phi = 2 * gmis::pi<double> * column / columns;
      const double distance = radius * (0.8 + 0.2 * uniform<double>(source));
      mesh.positions.push_back(center + distance * glm::dvec3(std::sin(theta) * std::cos(phi),
                                                              std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  const auto at = [&](int row, int column) { return 2 + (row - 1) * columns + column % columns; };
  for (int column = 0; column < columns; ++column) {
    mesh.triangles.push_back({0, at(1, column), at(1, column + 1)});
    mesh.triangles.push_back({1, at(rows - 1, column + 1), at(rows - 1, column)});
    for (int row = 1; row + 1 < rows; ++row) {
      mesh.triangles.push_back({at(row, column), at(row + 1, column), at(row + 1, column + 1)});
      mesh.triangles.push_back({at(row, column), at(row + 1, column + 1), at(row, column + 1)});
    }
  }
  return mesh;
}

template <std::floating_point T>
Vec2<T> random_square(Philox& source) {
  const T x = uniform<T>(source);
  return {x, uniform<T>(source)};
}
template <std::floating_point T>
Vec3<T> random_direction(Philox& source) {
  return glm::normalize(gmis::square_to_sphere(random_square<T>(source)));
}
inline glm::dvec3 random_in_cube(Philox& source) {
  const double x = uniform<double>(source), y = uniform<double>(source), z = uniform<double>(source);
  return glm::dvec3(x, y, z) * 2.0 - 1.0;
}
/// 10^x, x uniform.
inline double random_magnitude(Philox& source, double lowest, double highest) {
  return std::pow(10.0, lowest + (highest - lowest) * uniform<double>(source));
}

inline gmis::scene::CameraDescription camera_at(const glm::dvec3& eye) {
  return gmis::scene::look_at(eye, eye + glm::dvec3(0, 0, 1), {0, 1, 0}, 60, {16, 16});
}

}  // namespace scene_test
