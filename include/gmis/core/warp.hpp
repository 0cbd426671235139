#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "gmis/core/cos_sin.hpp"
#include "gmis/core/math.hpp"

/// \file
/// Maps from the unit square to disks, triangles and unit directions, with the density of the
/// result. Local frames have their axis along +z. Every map is a bijection up to a null set and
/// never fails.

namespace gmis {

/// Uniform point on the unit disk, density 1/π per area; neighbouring points stay neighbours
/// [Shirley, Chiu 1997].
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> square_to_disk(const Vec2<T>& u) noexcept {
  const T x = T(2) * u.x - T(1);
  const T y = T(2) * u.y - T(1);
  // The longer of the two is the radius (with a sign), and the angle from its axis is as far as the
  // other one reaches.
  const bool y_leads = std::abs(x) <= std::abs(y);
  const auto [radius, across] = detail::swapped_if(y_leads, x, y);
  if (radius == T(0)) return {T(0), T(0)};
  const auto [along_axis, off_axis] = cos_sin_of_eighths(across / radius);
  const auto [disk_x, disk_y] = detail::swapped_if(y_leads, radius * along_axis, radius * off_axis);
  return {disk_x, disk_y};
}

/// Direction on the upper hemisphere, density cos θ / π per steradian. Never on the horizon, where
/// the density is 0: cos θ is the machine epsilon at least.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_cosine_hemisphere(const Vec2<T>& u) noexcept {
  const Vec2<T> disk = square_to_disk(u);
  constexpr T least = std::numeric_limits<T>::epsilon() * std::numeric_limits<T>::epsilon();
  return {disk.x, disk.y, std::sqrt(std::max(least, T(1) - disk.x * disk.x - disk.y * disk.y))};
}

/// Uniform direction on the sphere, density 1/(4π) per steradian.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_sphere(const Vec2<T>& u) noexcept {
  const T z = T(1) - T(2) * u.x;
  const T radius = T(2) * sqrt_or_zero(u.x * (T(1) - u.x));
  const auto [cosine, sine] = cos_sin_of_turns(u.y);
  return {radius * cosine, radius * sine, z};
}

/// The inverse of `square_to_sphere`, for a unit vector.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> sphere_to_square(const Vec3<T>& w) noexcept {
  const T turn = std::atan2(w.y, w.x) / (T(2) * pi<T>);
  // (1 − z) / 2 = sin² of half the angle from z, accurate at both poles.
  const T sine_squared = w.x * w.x + w.y * w.y;
  const T share = w.z > T(0) ? sine_squared / (T(2) * (T(1) + w.z)) : (T(1) - w.z) / T(2);
  return {std::clamp(share, T(0), T(1)), turn < T(0) ? turn + T(1) : turn};
}

/// Direction on the upper hemisphere: the square, its corners at the horizon's axes, folded onto
/// half an octahedron and projected onto the sphere. `octahedral_hemisphere_density` is its
/// density.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_octahedral_hemisphere(const Vec2<T>& u) noexcept {
  const T x = u.x + u.y - T(1), y = u.x - u.y;
  return glm::normalize(Vec3<T>(x, y, std::max(T(0), T(1) - std::abs(x) - std::abs(y))));
}

/// The inverse of `square_to_octahedral_hemisphere`, for a unit vector with z ≥ 0.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> octahedral_hemisphere_to_square(const Vec3<T>& w) noexcept {
  const T scale = T(0.5) / (std::abs(w.x) + std::abs(w.y) + w.z);
  return {std::clamp(T(0.5) + (w.x + w.y) * scale, T(0), T(1)), std::clamp(T(0.5) + (w.x - w.y) * scale, T(0), T(1))};
}

/// Density of `square_to_octahedral_hemisphere` per steradian: 1/(2 (|x| + |y| + z)³). With P on
/// the octahedron, |P| = 1/(|x| + |y| + z): dω = dA cos/|P|² over its face, each factor √3 of area
/// cancels the cosine's 1/(√3 |P|), and the square has half the area of the octahedron's shadow.
template <std::floating_point T>
[[nodiscard]] inline T octahedral_hemisphere_density(const Vec3<T>& w) noexcept {
  const T sum = std::abs(w.x) + std::abs(w.y) + w.z;
  return T(1) / (T(2) * sum * sum * sum);
}

/// Barycentric coordinates (of the second and third corner) of a uniform point on a triangle,
/// density 1/area per area.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> square_to_triangle(const Vec2<T>& u) noexcept {
  const T root = std::sqrt(u.x);
  return {root * (T(1) - u.y), root * u.y};
}

/// The inverse of `square_to_triangle`; points beside the triangle are moved onto it.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> triangle_to_square(const Vec2<T>& b) noexcept {
  const T second = std::max(b.x, T(0)), third = std::max(b.y, T(0)), root = second + third;
  return {std::min(root * root, T(1)), root > T(0) ? third / root : T(0)};
}

/// Uniform direction in the cone cos θ ≥ 1 − `one_minus_cos`, density 1/(2π · one_minus_cos) per
/// steradian. The argument is 1 − cos θ_max, because the cosine of a narrow cone rounds to 1.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_cone(const Vec2<T>& u, T one_minus_cos) noexcept {
  const T drop = u.x * one_minus_cos;  // 1 − cos θ
  const T sin_theta = sqrt_or_zero(drop * (T(2) - drop));
  const auto [cosine, sine] = cos_sin_of_turns(u.y);
  return {sin_theta * cosine, sin_theta * sine, T(1) - drop};
}

}  // namespace gmis
