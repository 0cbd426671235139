#pragma once

#include "gmis/core/math.hpp"

/// \file
/// Maps of the unit square to directions and discs, each with the density it makes.
/// Local frames have their axis along +z. Every map is a bijection up to a null set; none can fail.

namespace gmis {

/// Uniform on the unit disk, area density 1/π; keeps neighbours together [Shirley, Chiu 1997].
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

/// Direction on the upper hemisphere with solid-angle density cos θ / π.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_cosine_hemisphere(const Vec2<T>& u) noexcept {
  const Vec2<T> disk = square_to_disk(u);
  return {disk.x, disk.y, sqrt_or_zero(T(1) - disk.x * disk.x - disk.y * disk.y)};
}

/// Direction on the sphere with solid-angle density 1/(4π).
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_sphere(const Vec2<T>& u) noexcept {
  const T z = T(1) - T(2) * u.x;
  const T radius = T(2) * sqrt_or_zero(u.x * (T(1) - u.x));
  const T angle = T(2) * pi<T> * u.y;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Barycentric coordinates (of the second and third corner) uniform on a triangle.
template <std::floating_point T>
[[nodiscard]] inline Vec2<T> square_to_triangle(const Vec2<T>& u) noexcept {
  const T root = std::sqrt(u.x);
  return {root * (T(1) - u.y), root * u.y};
}

/// Direction in the cone cos θ ≥ 1 − `one_minus_cos`, solid-angle density 1/(2π · one_minus_cos). The cone is given by
/// 1 − cos θ_max because a narrow one has a cosine that rounds to 1.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> square_to_cone(const Vec2<T>& u, T one_minus_cos) noexcept {
  const T drop = u.x * one_minus_cos;  // 1 − cos θ
  const T sin_theta = sqrt_or_zero(drop * (T(2) - drop));
  const T angle = T(2) * pi<T> * u.y;
  return {sin_theta * std::cos(angle), sin_theta * std::sin(angle), T(1) - drop};
}

}  // namespace gmis
