#pragma once

#include "gmis/core/attributes.hpp"
#include "gmis/core/cos_sin.hpp"
#include "gmis/core/math.hpp"

namespace gmis::scene {

/// The falloff of a spot light: its intensity in a direction relative to the intensity on the axis.
/// It is 1 within the inner cone, 0 outside the outer cone, and t²(3 − 2t) between them, where t
/// falls linearly in the cosine from 1 to 0 (as in pbrt-v4). Cosines are stored as 1 − cos, which
/// is accurate for narrow cones.
template <std::floating_point T>
class SpotCone {
 public:
  SpotCone() = default;
  /// `axis` has unit length. `inner` and `outer` are half angles in radians, 0 ≤ inner ≤ outer ≤ π,
  /// outer > 0.
  SpotCone(const Vec3<T>& axis, double inner, double outer) noexcept
      : axis_(axis),
        inner_(static_cast<T>(2 * square(std::sin(inner / 2)))),
        outer_(static_cast<T>(2 * square(std::sin(outer / 2)))) {}

  /// Falloff in [0, 1] for a unit direction away from the light.
  [[nodiscard]] T falloff(const Vec3<T>& direction) const noexcept {
    const Vec3<T> difference = direction - axis_;
    return falloff_at(glm::dot(difference, difference) / T(2));
  }
  [[nodiscard]] const Vec3<T>& axis() const noexcept { return axis_; }
  /// Half angle of the outer cone in radians.
  [[nodiscard]] double outer_angle() const noexcept {
    return 2 * std::asin(std::min(1.0, std::sqrt(static_cast<double>(outer_) / 2)));
  }
  /// ∫ falloff over the sphere, in steradians: the flux of a spot light with intensity 1 on the
  /// axis.
  [[nodiscard]] T solid_angle() const noexcept { return pi<T> * (inner_ + outer_); }

  struct Sample {
    Vec3<T> direction;
    T density;  ///< per steradian: falloff / solid_angle()
  };
  /// A direction with a density exactly proportional to `falloff`.
  [[nodiscard]] GMIS_NEVER_INLINE Sample sample(Vec2<T> uv) const noexcept {
    // In 1 − cos, the zone between the cones has the mean falloff 1/2.
    const T inner_share = T(2) * inner_ / (inner_ + outer_);
    const T drop = uv.x < inner_share
                       ? inner_ * (uv.x / inner_share)
                       : outer_ - (outer_ - inner_) * inverse_of_integral((T(1) - uv.x) / (T(1) - inner_share));
    const T sine = sqrt_or_zero(drop * (T(2) - drop));
    const auto turn = cos_sin_of_turns(uv.y);
    return {Frame<T>::around(axis_).to_world({sine * turn.cos, sine * turn.sin, T(1) - drop}),
            falloff_at(drop) / solid_angle()};
  }

 private:
  /// Falloff at an angle to the axis; `drop` is 1 − cos of the angle.
  [[nodiscard]] T falloff_at(T drop) const noexcept {
    if (drop <= inner_) return T(1);
    if (drop >= outer_) return T(0);
    const T t = (outer_ - drop) / (outer_ - inner_);
    return t * t * (T(3) - T(2) * t);
  }

  /// The t in [0, 1] with 2t³ − t⁴ = u: the integral of t²(3 − 2t) from 0 to t is the share u of
  /// the integral over [0, 1].
  [[nodiscard]] static T inverse_of_integral(T u) noexcept {
    const T root = std::cbrt(std::clamp(u, T(0), T(1)));
    if (root == T(0)) return T(0);
    // Newton's method from above converges monotonically, because 2t³ − t⁴ is convex on [0, 1].
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
