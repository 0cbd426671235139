#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/core/warp.hpp"
#include "gmis/scene/bvh_build.hpp"

/// \file
/// The meshes that the trees are compared on, and where each is seen and lit from.

namespace bench_bvh {

using gmis::Philox;
using gmis::uniform;
using gmis::Vec3;

struct Mesh {
  std::string name;
  std::vector<Vec3<float>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Vec3<float> eye{0}, target{0};
  Vec3<float> light{0};  ///< centre of a cube of edge `light_size`, in which the ends of shadow rays lie
  float light_size = 0;
  float half_height = 0.45F;  ///< tangent of half the vertical angle of view; the horizontal one's is 0.45

  [[nodiscard]] std::vector<gmis::scene::TriangleCorners<float>> corners() const {
    std::vector<gmis::scene::TriangleCorners<float>> all;
    all.reserve(triangles.size());
    for (const auto& t : triangles) all.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
    return all;
  }
};

inline Vec3<float> random_in_cube(Philox& source) {
  const float x = uniform<float>(source), y = uniform<float>(source), z = uniform<float>(source);
  return Vec3<float>(x, y, z) * 2.0F - 1.0F;
}

/// Adds `rows` × `columns` squares of two triangles; corner (i, j) is at
/// `at(i / rows, j / columns)`.
template <class At>
void add_grid(Mesh& mesh, std::uint32_t rows, std::uint32_t columns, At&& at) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t i = 0; i <= rows; ++i)
    for (std::uint32_t j = 0; j <= columns; ++j)
      mesh.positions.push_back(at(static_cast<double>(i) / rows, static_cast<double>(j) / columns));
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t a = first + i * (columns + 1) + j, b = a + 1, c = a + columns + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
}

template <class Distance>
void add_ball(Mesh& mesh, std::uint32_t rows, const glm::dvec3& center, Distance&& distance) {
  add_grid(mesh, rows, 2 * rows, [&](double u, double v) {
    const double theta = std::numbers::pi * u, phi = 2 * std::numbers::pi * v;
    const glm::dvec3 to(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    return Vec3<float>(center + to * distance(to));
  });
}

/// A million triangles at `scale` 1.
inline Mesh displaced_sphere(double scale) {
  Mesh mesh{"displaced sphere", {}, {}, {0, 0.4F, -2.6F}, {0, 0, 0}, {2, 3, -2}, 1};
  add_ball(mesh, static_cast<std::uint32_t>(500 * std::sqrt(scale)), {0, 0, 0}, [](const glm::dvec3& d) {
    return 1 + 0.06 * std::sin(9 * d.x) * std::sin(11 * d.y) * std::sin(7 * d.z) +
           0.012 * std::sin(61 * d.x + 3) * std::sin(53 * d.y) * std::sin(47 * d.z + 1);
  });
  return mesh;
}

/// 400 balls of many sizes, 800 triangles each at `scale` 1.
inline Mesh clutter(double scale) {
  Mesh mesh{"clutter of balls", {}, {}, {0, 0, -14}, {0, 0, 0}, {0, 12, -8}, 2};
  Philox source(1);
  for (int i = 0; i < 400; ++i) {
    const glm::dvec3 center = glm::dvec3(random_in_cube(source)) * 5.0;
    const double radius = std::pow(10.0, -1.2 + 1.2 * uniform<double>(source));
    add_ball(mesh, static_cast<std::uint32_t>(14 * std::sqrt(scale)), center,
             [&](const glm::dvec3&) { return radius; });
  }
  return mesh;
}

/// 100 000 long, thin triangles in all directions at `scale` 1.
inline Mesh thin_soup(double scale) {
  Mesh mesh{"thin soup", {}, {}, {0, 0, -3}, {0, 0, 0}, {0, 3, 0}, 0.5F};
  Philox source(2);
  const auto count = static_cast<std::uint32_t>(100'000 * scale);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3<float> center = random_in_cube(source), along = random_in_cube(source) * 0.1F;
    mesh.positions.push_back(center - along);
    mesh.positions.push_back(center + along);
    mesh.positions.push_back(center + random_in_cube(source) * 0.004F);
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// Half a million triangles at `scale` 1.
inline Mesh terrain(double scale) {
  Mesh mesh{"terrain", {}, {}, {0, 1.2F, -5}, {0, 0, 0}, {4, 4, 4}, 1};
  const auto rows = static_cast<std::uint32_t>(500 * std::sqrt(scale));
  add_grid(mesh, rows, rows, [](double u, double v) {
    double height = 0, x = 5 * u, z = 5 * v, amplitude = 0.5;
    for (int octave = 0; octave < 7; ++octave) {
      height += amplitude * std::sin(x + 1.3 * octave) * std::sin(z + 2.1 * octave);
      const double turned = 1.6 * x + 1.2 * z;
      z = 1.6 * z - 1.2 * x;
      x = turned;
      amplitude *= 0.5;
    }
    return Vec3<float>(glm::dvec3(8 * u - 4, height, 8 * v - 4));
  });
  return mesh;
}

/// Half a million triangles in one plane at `scale` 1, seen from near that plane.
inline Mesh plane_edge_on(double scale) {
  Mesh mesh{"plane edge on", {}, {}, {0, 0.01F, -6}, {0, 0, 0}, {0, 0.3F, 0}, 0.1F, 0.005F};
  const auto rows = static_cast<std::uint32_t>(500 * std::sqrt(scale));
  // Turned a little, so that no plane of a box is that of the mesh.
  add_grid(mesh, rows, rows, [](double u, double v) {
    const double x = 8 * u - 4, z = 8 * v - 4;
    return Vec3<float>(glm::dvec3(x, 0.002 * x - 0.001 * z, z));
  });
  return mesh;
}

inline std::vector<std::function<Mesh(double)>> all_meshes() {
  return {displaced_sphere, clutter, thin_soup, terrain, plane_edge_on};
}

}  // namespace bench_bvh
