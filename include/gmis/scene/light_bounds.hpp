#pragma once

#include <algorithm>
#include <cmath>

#include "gmis/scene/box.hpp"

namespace gmis::scene {

/// Where a light, or a group of lights, shines from and in which directions. Every direction that
/// light takes is within `emission` of a normal that is within `spread` of `axis`; angles in
/// radians. A sphere or a point light has the spread π and thus all directions.
struct LightBounds {
  Box<double> box;                   ///< of all points that shine
  glm::dvec3 axis{0, 0, 1};          ///< unit, of the cone of normals
  double spread = pi<double>;        ///< largest angle of a normal with the axis
  double emission = pi<double> / 2;  ///< largest angle of emitted light with its normal
  double power = 0;                  ///< flux

  /// Bounds of both. An empty box is that of no light.
  [[nodiscard]] static LightBounds of_both(const LightBounds& first, const LightBounds& second) {
    if (first.box.is_empty()) return second;
    if (second.box.is_empty()) return first;
    const bool is_first_wider = first.spread >= second.spread;
    const LightBounds& wide = is_first_wider ? first : second;
    const LightBounds& narrow = is_first_wider ? second : first;
    LightBounds both = wide;
    both.box.add(narrow.box);
    both.emission = std::max(wide.emission, narrow.emission);
    both.power = wide.power + narrow.power;
    const double apart = std::acos(std::clamp(glm::dot(wide.axis, narrow.axis), -1.0, 1.0));
    if (apart + narrow.spread <= wide.spread) return both;
    both.spread = (wide.spread + apart + narrow.spread) / 2;
    if (both.spread >= pi<double> || apart > pi<double> - 1e-6) {
      both.spread = pi<double>;
      return both;
    }
    // The wide axis turned towards the narrow one.
    const double turn = both.spread - wide.spread;
    both.axis = glm::normalize((std::sin(apart - turn) * wide.axis + std::sin(turn) * narrow.axis) / std::sin(apart));
    return both;
  }

  /// ∫ over all directions of the cosine with which they leave the cone of normals, at most π/2
  /// wide beyond it [Conty Estevez, Kulla 2018, the orientation measure M_Ω]. Steradians.
  [[nodiscard]] double orientation_measure() const {
    const double reach = std::min(spread + emission, pi<double>);
    return 2 * pi<double> * (1 - std::cos(spread)) + pi<double> / 2 *
                                                         (2 * reach * std::sin(spread) - std::cos(spread - 2 * reach) -
                                                          2 * spread * std::sin(spread) + std::cos(spread));
  }
  /// power · area of the box · orientation measure: what a group costs that is chosen as a whole
  /// (the surface area orientation heuristic of the same paper).
  [[nodiscard]] double cost() const {
    if (box.is_empty()) return 0;
    const glm::dvec3 size = box.upper - box.lower;
    // A share of the squared diagonal, so that flat and thin boxes cost something, too.
    return power * (box.half_area() + 1e-3 * glm::dot(size, size)) * orientation_measure();
  }
};

}  // namespace gmis::scene
