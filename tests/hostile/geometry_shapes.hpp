#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "scene/shapes.hpp"

/// \file
/// Closed convex bodies with sharp edges and what is true of them, in double precision.

namespace hostile {

using gmis::Philox;
using gmis::uniform;
using gmis::Vec3;
using scene_test::Mesh;
using scene_test::random_in_cube;
using scene_test::random_magnitude;

/// A mesh alone, as a camera sees it from `eye`.
template <std::floating_point T>
gmis::scene::BvhScene<T> scene_of(const Mesh& mesh, const gmis::scene::Material<T>& material, const glm::dvec3& eye) {
  gmis::scene::SceneBuilder<T> builder;
  builder.add_mesh(mesh.shape(), builder.add_material(material));
  builder.set_camera(scene_test::camera_at(eye));
  return builder.build();
}

/// Convex, with outward normals; `inner` is the radius of a ball around the origin that is wholly
/// inside.
struct Body {
  Mesh mesh;
  double inner = 0;
};

/// The distance of the nearest face's plane from the origin; the smallest height of a triangle; the
/// smallest angle between two faces that share an edge, measured within the body.
struct BodyMeasures {
  double inner = std::numeric_limits<double>::infinity();
  double lowest_height = std::numeric_limits<double>::infinity();
  double sharpest_edge = gmis::pi<double>;
};

inline glm::dvec3 normal_of(const Mesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const auto at = [&](int corner) {
    return mesh.positions[static_cast<std::size_t>(t[static_cast<std::size_t>(corner)])];
  };
  return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
}

inline BodyMeasures measure(const Mesh& mesh) {
  BodyMeasures result;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const glm::dvec3 n = normal_of(mesh, i);
    result.inner = std::min(result.inner, glm::dot(n, mesh.positions[static_cast<std::size_t>(t[0])]));
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 a = mesh.positions[static_cast<std::size_t>(t[k])];
      const glm::dvec3 b = mesh.positions[static_cast<std::size_t>(t[(k + 1) % 3])];
      const glm::dvec3 c = mesh.positions[static_cast<std::size_t>(t[(k + 2) % 3])];
      result.lowest_height = std::min(result.lowest_height, glm::length(glm::cross(b - a, c - a)) / glm::length(b - a));
    }
    for (std::size_t j = 0; j < i; ++j) {
      int shared = 0;
      for (const int corner : t)
        shared += std::count(mesh.triangles[j].begin(), mesh.triangles[j].end(), corner) > 0 ? 1 : 0;
      if (shared == 2)
        result.sharpest_edge = std::min(
            result.sharpest_edge, gmis::pi<double> - std::acos(std::clamp(glm::dot(n, normal_of(mesh, j)), -1.0, 1.0)));
    }
  }
  return result;
}

inline glm::dvec3 rotated(const glm::dvec3& v, const gmis::Frame<double>& frame) {
  return frame.to_world(v);
}

/// Within the unit ball: a box along the axes, a regular octahedron or icosahedron or a random
/// tetrahedron, the last three turned at random. Edges of 25° and more, triangles not lower than
/// 0.2.
inline Body random_body(Philox& source) {
  Body body;
  Mesh& mesh = body.mesh;
  const auto kind = static_cast<int>(uniform<double>(source) * 4);
  const auto frame = gmis::Frame<double>::around(scene_test::random_direction<double>(source));
  const auto add = [&](const glm::dvec3& v) { mesh.positions.push_back(rotated(glm::normalize(v), frame)); };
  if (kind == 0) {
    const glm::dvec3 half = glm::dvec3(1, 0.4 + 0.6 * uniform<double>(source), 0.5) * 0.57;
    mesh = scene_test::box(-half, half);
  } else if (kind == 1) {
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) {
        glm::dvec3 v(0);
        v[axis] = sign;
        add(v);
      }
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  } else if (kind == 2) {
    const double g = (1 + std::sqrt(5.0)) / 2;
    for (const glm::dvec3 v : {glm::dvec3(-1, g, 0),
                               {1, g, 0},
                               {-1, -g, 0},
                               {1, -g, 0},
                               {0, -1, g},
                               {0, 1, g},
                               {0, -1, -g},
                               {0, 1, -g},
                               {g, 0, -1},
                               {g, 0, 1},
                               {-g, 0, -1},
                               {-g, 0, 1}})
      add(v);
    mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  } else {
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    for (;;) {
      mesh.positions.clear();
      for (int k = 0; k < 4; ++k) mesh.positions.push_back(scene_test::random_direction<double>(source));
      glm::dvec3 middle(0);
      for (const auto& p : mesh.positions) middle += p / 4.0;
      for (auto& p : mesh.positions) p = (p - middle) / 1.5;
      if (glm::dot(normal_of(mesh, 0), mesh.positions[0]) < 0) std::swap(mesh.positions[0], mesh.positions[1]);
      const BodyMeasures found = measure(mesh);
      if (found.inner > 0.05 && found.lowest_height > 0.2 && found.sharpest_edge > 25 * gmis::pi<double> / 180) break;
    }
  }
  body.inner = measure(mesh).inner;
  return body;
}

/// On an edge of the mesh or at a corner of it (every fourth), exactly or nearly: off by 10^−1 …
/// 10^−9 of the length, or not at all.
inline glm::dvec3 point_near_edge(const Mesh& mesh, Philox& source) {
  const auto count = static_cast<double>(mesh.triangles.size());
  const auto& t = mesh.triangles[static_cast<std::size_t>(uniform<double>(source) * count)];
  const auto k = static_cast<std::size_t>(uniform<double>(source) * 3);
  const glm::dvec3 a = mesh.positions[static_cast<std::size_t>(t[k])];
  const glm::dvec3 b = mesh.positions[static_cast<std::size_t>(t[(k + 1) % 3])];
  const double along = uniform<double>(source) < 0.25 ? 0.0 : uniform<double>(source);
  const double off = uniform<double>(source) < 0.3 ? 0.0 : random_magnitude(source, -9, -1);
  return a + (b - a) * along + random_in_cube(source) * (off * glm::length(b - a));
}

/// Unit, on the side of the unit `normal` that `side` says, the cosine between them 10^−x: from
/// steep to grazing.
template <std::floating_point T>
Vec3<T> direction_on_side(const Vec3<T>& normal, T side, Philox& source) {
  const double lowest = std::same_as<T, float> ? -7.5 : -16;
  const double cosine = random_magnitude(source, uniform<double>(source) < 0.3 ? -1 : lowest, 0);
  const double angle = 2 * gmis::pi<double> * uniform<double>(source);
  const double sine = std::sqrt(1 - cosine * cosine);
  const auto frame = gmis::Frame<double>::around(glm::normalize(glm::dvec3(normal)));
  Vec3<T> w(frame.to_world({sine * std::cos(angle), sine * std::sin(angle), cosine * static_cast<double>(side)}));
  if (glm::dot(w, normal) * side <= T(0)) w = normal * side;  // rounding took it over the horizon
  return w;
}

}  // namespace hostile
