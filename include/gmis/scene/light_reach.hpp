#pragma once

#include <algorithm>
#include <cmath>

#include "gmis/core/math.hpp"

/// \file
/// Upper bounds of the share of a light's flux that meets a ball, the one around all surfaces that
/// do not shine. Power times share is the flux that can be of use: by power alone, a sun that is a
/// far sphere hides a lamp in the room. Distances are from the middle of the light to the centre of
/// the ball, angles are in radians.

namespace gmis::scene {

/// The ball around the surfaces that lights are to reach.
struct ReceiverBall {
  glm::dvec3 center{0};  ///< in the space of the lights
  double radius = 0;     ///< below 0: there is no such surface
};
/// Half the angle under which a ball is seen from a point outside.
struct HalfAngle {
  double sine_squared;  ///< sin²
  double cosine;        ///< cos
  /// For a ball with this radius at this larger distance.
  [[nodiscard]] static HalfAngle of(double radius, double distance) noexcept {
    const double sine_squared = std::min(1.0, square(radius / distance));
    return {sine_squared, std::sqrt(1.0 - sine_squared)};
  }
  /// 1 − cos, accurate for small angles.
  [[nodiscard]] double drop() const noexcept { return sine_squared / (1.0 + cosine); }
};

/// Share of a light that shines from a point into all directions alike: the share of the sphere of
/// directions that the ball covers, (1 − √(1 − R²/d²))/2, exactly.
[[nodiscard]] inline double share_of_point(double distance, double radius) noexcept {
  return distance > radius ? 0.5 * HalfAngle::of(radius, distance).drop() : 1.0;
}

/// Share of a spot light, whose axis is at `angle` to the direction of the ball. `outer` is the
/// half angle of its cone and `solid_angle` its flux for an intensity of 1 on the axis.
[[nodiscard]] inline double share_of_spot(double distance, double angle, double outer, double solid_angle,
                                          double radius) noexcept {
  if (!(distance > radius)) return 1.0;
  const HalfAngle half = HalfAngle::of(radius, distance);
  if (angle > outer + std::acos(half.cosine)) return 0.0;
  return solid_angle > 0.0 ? std::min(1.0, 2.0 * pi<double> * half.drop() / solid_angle) : 1.0;
}

/// Share of a sphere with radius `own` that shines evenly from either side or both. In every
/// direction it sends a beam that is as wide as itself. At most R²/r² of the beam meets the ball,
/// and only when the direction is nearer to that of the ball than asin((r + R)/d). Over all
/// directions in the plane, the areas that beam and ball share integrate to πr² · πR², so the share
/// is R²/(4 d²) from far away.
[[nodiscard]] inline double share_of_sphere(double distance, double own, double radius) noexcept {
  const double widest = radius < own ? square(radius / own) : 1.0;
  if (!(distance > own + radius)) return widest;
  const HalfAngle half = HalfAngle::of(own + radius, distance);
  const double far = half.cosine > 0.0 ? square(radius / distance) / (4.0 * half.cosine) : 1.0;
  return std::min(widest * 0.5 * half.drop(), far);
}

/// Share of a flat light of this area, whose points are at most `own` from its middle. `cosine` is
/// that between its normal and the direction of the ball. A point with the normal at an angle θ to
/// the ball sends the share sin² α cos θ to it when the ball is above the horizon, at most sin³ α
/// when the horizon cuts it, and nothing when it is below. A parallel beam of the light meets the
/// ball over an area of at most πR²; over all directions of the hemisphere the share is at most
/// 2πR²/area.
[[nodiscard]] inline double share_of_facet(double distance, double cosine, double own, double area, bool is_two_sided,
                                           double radius) noexcept {
  const double all_round = 2.0 * pi<double> * square(radius);
  const double widest = all_round < area ? all_round / area : 1.0;
  const double nearest = distance - own;
  if (!(nearest > radius)) return widest;
  const HalfAngle half = HalfAngle::of(radius, nearest);
  const double sine = std::sqrt(half.sine_squared);
  // Points of the light see the ball in directions up to `turn` from that of the middle.
  const double turn = std::asin(std::min(1.0, own / distance));
  const double angle = std::acos(std::clamp(is_two_sided ? std::abs(cosine) : cosine, -1.0, 1.0)) - turn;
  if (angle > pi<double> / 2.0 + std::asin(sine)) return 0.0;
  // The two sides send half of the flux each, and both reach a ball that the plane cuts.
  const bool is_cut = angle + 2.0 * turn + std::asin(sine) > pi<double> / 2.0;
  const double sides = is_two_sided && !is_cut ? 0.5 : 1.0;
  return std::min(widest, sides * half.sine_squared * std::max(std::cos(std::max(0.0, angle)), sine));
}

}  // namespace gmis::scene
