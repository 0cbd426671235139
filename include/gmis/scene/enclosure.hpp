#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/scene/box.hpp"
#include "gmis/scene/bvh_build.hpp"

namespace gmis::scene {

/// The box around some shapes, and the smallest ball about the centre of the box that holds them.
struct Enclosure {
  Box<double> box;       ///< empty without shapes
  glm::dvec3 center{0};  ///< of the box
  double radius = 0;     ///< of the ball
};

/// Around triangle i where `counts_triangle(i)` holds, and ball i where `counts_ball(i)` does.
template <std::floating_point T, class CountsTriangle, class CountsBall>
[[nodiscard]] Enclosure enclosure_of(const std::vector<TriangleCorners<T>>& triangles,
                                     const std::vector<SphereShape<T>>& balls, const CountsTriangle& counts_triangle,
                                     const CountsBall& counts_ball) {
  Enclosure all;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (counts_triangle(i))
      for (const auto& corner : triangles[i]) all.box.add(glm::dvec3(corner));
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (counts_ball(i)) {
      all.box.add(glm::dvec3(balls[i].center) - static_cast<double>(balls[i].radius));
      all.box.add(glm::dvec3(balls[i].center) + static_cast<double>(balls[i].radius));
    }
  if (all.box.is_empty()) return all;
  all.center = (all.box.lower + all.box.upper) * 0.5;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (counts_triangle(i))
      for (const auto& corner : triangles[i])
        all.radius = std::max(all.radius, glm::length(glm::dvec3(corner) - all.center));
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (counts_ball(i)) {
      const double to_middle = glm::length(glm::dvec3(balls[i].center) - all.center);
      all.radius = std::max(all.radius, to_middle + static_cast<double>(balls[i].radius));
    }
  return all;
}

}  // namespace gmis::scene
