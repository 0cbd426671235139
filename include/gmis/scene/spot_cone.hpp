#pragma once

#include "gmis/core/math.hpp"

namespace gmis::scene {

/// The share of a spot light's intensity that goes into each direction: 1 within an inner cone, 0 beyond an outer one,
/// and between them t²(3 − 2t), t falling linearly in the cosine from 1 to 0 (pbrt-v4's). Cosines are kept as
/// 1 − cos, so that narrow cones lose no digits.
template <std::floating_point T>
class SpotCone {
 public:
  SpotCone() = default;
  /// `axis` of unit length; half angles in radians, 0 ≤ inner ≤ outer ≤ π, outer > 0.
  SpotCone(const Vec3<T>& axis, double inner, double outer) noexcept
      : axis_(axis),
        inner_(static_cast<T>(2 * square(std::sin(inner / 2)))),
        outer_(static_cast<T>(2 * square(std::sin(outer / 2)))) {}

  [[nodiscard]] T falloff(const Vec3<T>& direction) const noexcept {
    const Vec3<T> difference = direction - axis_;
    return falloff_at(glm::dot(difference, difference) / T(2));
  }
  /// ∫ falloff over the sphere: the flux of a spot of intensity 1.
  [[nodiscard]] T solid_angle() const noexcept { return pi<T> * (inner_ + outer_); }

  struct Sample {
    Vec3<T> direction;
    T density;  ///< per steradian: falloff / solid_angle()
  };
  /// In exact proportion to `falloff`.
  [[nodiscard]] Sample sample(const Vec2<T>& uv) const noexcept {
    // Half of what is between the cones counts.
    const T inner_share = T(2) * inner_ / (inner_ + outer_);
    const T drop = uv.x < inner_share
                       ? inner_ * (uv.x / inner_share)
                       : outer_ - (outer_ - inner_) * inverse_of_integral((T(1) - uv.x) / (T(1) - inner_share));
    const T sine = sqrt_or_zero(drop * (T(2) - drop));
    const T turn = T(2) * pi<T> * uv.y;
    return {Frame<T>::around(axis_).to_world({sine * std::cos(turn), sine * std::sin(turn), T(1) - drop}),
            falloff_at(drop) / solid_angle()};
  }

 private:
  /// `drop`: 1 − cos of the angle to the axis.
  [[nodiscard]] T falloff_at(T drop) const noexcept {
    if (drop <= inner_) return T(1);
    if (drop >= outer_) return T(0);
    const T t = (outer_ - drop) / (outer_ - inner_);
    return t * t * (T(3) - T(2) * t);
  }

  /// The t in [0, 1] with 2t³ − t⁴ = u, which is where the integral of the falloff has the share u of its whole.
  [[nodiscard]] static T inverse_of_integral(T u) noexcept {
    const T root = std::cbrt(std::clamp(u, T(0), T(1)));
    if (root == T(0)) return T(0);
    // From above Newton's method comes down to the solution: 2t³ − t⁴ is convex on [0, 1].
    T t = std::min(T(1), root);
    for (int step = 0; step < 6; ++step) {
      const T t2 = t * t;
      t -= (t * t2 * (T(2) - t) - u) / (t2 * (T(6) - T(4) * t));
    }
    return std::clamp(t, T(0), T(1));
  }

  Vec3<T> axis_{T(0), T(0), T(1)};
  T inner_ = 0, outer_ = 0;
};

}  // namespace gmis::scene
