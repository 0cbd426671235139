#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>

namespace gmis {

template <std::floating_point T>
using Vec2 = glm::vec<2, T>;
template <std::floating_point T>
using Vec3 = glm::vec<3, T>;

template <std::floating_point T>
inline constexpr T pi = std::numbers::pi_v<T>;

template <std::floating_point T>
[[nodiscard]] constexpr T square(T x) noexcept {
  return x * x;
}

/// √x; 0 when rounding made x negative.
template <std::floating_point T>
[[nodiscard]] inline T sqrt_or_zero(T x) noexcept {
  return std::sqrt(std::max(x, T(0)));
}

/// An orthonormal, right-handed frame around a unit vector.
template <std::floating_point T>
struct Frame {
  Vec3<T> tangent;    ///< x axis
  Vec3<T> bitangent;  ///< y axis
  Vec3<T> normal;     ///< z axis

  /// The frame whose third axis is `axis` (unit); continuous except where axis.z changes sign
  /// [Duff et al., Building an orthonormal basis, revisited, JCGT 2017].
  [[nodiscard]] static Frame around(const Vec3<T>& axis) noexcept {
    const T sign = std::copysign(T(1), axis.z);
    const T a = T(-1) / (sign + axis.z);
    const T b = axis.x * axis.y * a;
    return {
        {T(1) + sign * axis.x * axis.x * a, sign * b, -sign * axis.x}, {b, sign + axis.y * axis.y * a, -axis.y}, axis};
  }

  /// The vector with these coordinates in the frame.
  [[nodiscard]] Vec3<T> to_world(const Vec3<T>& local) const noexcept {
    return tangent * local.x + bitangent * local.y + normal * local.z;
  }
  /// The coordinates of a vector in the frame.
  [[nodiscard]] Vec3<T> to_local(const Vec3<T>& world) const noexcept {
    return {glm::dot(tangent, world), glm::dot(bitangent, world), glm::dot(normal, world)};
  }
};

/// Mirror image of `direction` about the unit `normal`. Both directions point away from the
/// surface.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> reflect_about(const Vec3<T>& direction, const Vec3<T>& normal) noexcept {
  return normal * (T(2) * glm::dot(direction, normal)) - direction;
}

}  // namespace gmis
