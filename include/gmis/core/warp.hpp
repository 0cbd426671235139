#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "gmis/core/math.hpp"

/// \file
/// Maps from the unit square to disks, triangles and unit directions, with the density of the result. Local frames have
/// their axis along +z. Every map is a bijection up to a null set and never fails.

namespace gmis {

/// Uniform point on the unit disk, density 1/π per area; neighbouring points stay neighbours [Shirley, Chiu 1997].
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> square_to_disk(const Vec2<T>& u) noexcept {
  const T x = T(2) * u.x - T(1);
  const T y = T(2) * u.y - T(1);
  if (x == T(0) && y == T(0)) return {T(0), T(0)};
  const bool x_leads = std::abs(x) > std::abs(y);
  const T radius = x_leads ? x : y;
  const T angle = x_leads ? (pi<T> / T(4)) * (y / x) : (pi<T> / T(2)) - (pi<T> / T(4)) * (x / y);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Direction on the upper hemisphere, density cos θ / π per steradian. Never on the horizon, where the density is 0: cos θ is
/// the machine epsilon at least.
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
  const T angle = T(2) * pi<T> * u.y;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Barycentric coordinates (of the second and third corner) of a uniform point on a triangle, density 1/area per area.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> square_to_triangle(const Vec2<T>& u) noexcept {
  const T root = std::sqrt(u.x);
  return {root * (T(1) - u.y), root * u.y};
}

/// Uniform direction in the cone cos θ ≥ 1 − `one_minus_cos`, density 1/(2π · one_minus_cos) per steradian. The
/// argument is 1 − cos θ_max, because the cosine of a narrow cone rounds to 1.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_cone(const Vec2<T>& u, T one_minus_cos) noexcept {
  const T drop = u.x * one_minus_cos;  // 1 − cos θ
  const T sin_theta = sqrt_or_zero(drop * (T(2) - drop));
  const T angle = T(2) * pi<T> * u.y;
  return {sin_theta * std::cos(angle), sin_theta * std::sin(angle), T(1) - drop};
}

}  // namespace gmis
