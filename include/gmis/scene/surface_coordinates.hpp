#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// Where on a surface a point is.
template <std::floating_point T>
struct SurfaceCoordinates {
  Vec2<T> uv{0};        ///< texture coordinates
  Vec3<T> along_u{0};   ///< ∂p/∂u, in scene units; 0 where the surface has no usable coordinates
  Vec3<T> along_v{0};   ///< derivative of the position by v
  Vec3<T> position{0};  ///< in scene units
  /// Points nearer to each other than this are taken for one where a point is chosen by chance; a
  /// power of two, or 0.
  T cell = 0;

  /// Sets `cell` for positions with this error: 2 to 4 times as wide. Nearly all rays to a point
  /// then find the same cell, and a pixel has thousands of cells. Wide cells would show: the
  /// pattern is the same in every iteration.
  void set_cell(T position_error) noexcept {
    if (position_error > T(0)) cell = std::ldexp(T(1), std::ilogb(position_error) + 2);
  }
};

/// The coordinates of the corners of a triangle.
template <std::floating_point T>
using TriangleCoordinates = std::array<Vec2<T>, 3>;

/// At the point of a triangle with these weights of its corners.
template <std::floating_point T>
[[nodiscard]] inline SurfaceCoordinates<T> triangle_coordinates(const TriangleCoordinates<T>& uv,
                                                                const std::array<Vec3<T>, 3>& corners,
                                                                const Vec3<T>& weights,
                                                                const Vec3<T>& position) noexcept {
  SurfaceCoordinates<T> result;
  result.uv = uv[0] * weights.x + uv[1] * weights.y + uv[2] * weights.z;
  result.position = position;
  const Vec2<T> a = uv[1] - uv[0], b = uv[2] - uv[0];
  const Vec3<T> along_a = corners[1] - corners[0], along_b = corners[2] - corners[0];
  const T area = a.x * b.y - a.y * b.x;
  if (!(std::abs(area) > T(1e-12) * (glm::length(a) * glm::length(b)))) return result;
  result.along_u = (along_a * b.y - along_b * a.y) / area;
  result.along_v = (along_b * a.x - along_a * b.x) / area;
  return result;
}

/// At the point of a sphere where the outward unit normal is `outward`. `axes` are those of the
/// sphere: u runs from x by way of y around z, v from −z to z.
template <std::floating_point T>
[[nodiscard]] inline SurfaceCoordinates<T> sphere_coordinates(const std::array<Vec3<T>, 3>& axes, T radius,
                                                              const Vec3<T>& outward,
                                                              const Vec3<T>& position) noexcept {
  const T x = glm::dot(axes[0], outward), y = glm::dot(axes[1], outward), z = glm::dot(axes[2], outward);
  const T sine = std::sqrt(x * x + y * y);
  const T turn = std::atan2(y, x);
  SurfaceCoordinates<T> result;
  result.uv = {(turn < T(0) ? turn / (T(2) * pi<T>)+T(1) : turn / (T(2) * pi<T>)), T(1) - std::atan2(sine, z) / pi<T>};
  result.position = position;
  const auto world = [&](T a, T b, T c) { return (axes[0] * a + axes[1] * b + axes[2] * c) * radius; };
  result.along_u = world(-y, x, T(0)) * (T(2) * pi<T>);
  if (sine > T(0)) result.along_v = world(-z * x / sine, -z * y / sine, sine) * pi<T>;
  return result;
}

}  // namespace gmis::scene
