#pragma once

#include <algorithm>
#include <limits>

#include "gmis/core/math.hpp"

/// \file
/// A ray that leaves a triangle starts beside it, `position_error` away along the normal. Near an edge this may already be
/// behind the triangle that meets this one there, as may be the point itself, which is rounded along the triangle too: the
/// ray then leaks into what the two enclose, or out of it. Points nearer to an edge than a few such errors are therefore
/// moved to that distance, within the triangle. Where triangles meet at 20° or more no start is on the wrong side then.

namespace gmis::scene {

/// Barycentric coordinates, one per corner, that are at least as large as keeps a point off the edges. 0 where the triangle
/// is too thin for that, a sliver of a few roundings: there, a point would be moved along it to no avail.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> edge_margins(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c,
                                          T position_error) noexcept {
  const Vec3<T> ab = b - a, ac = c - a, bc = c - b;
  const T twice_area = glm::length(glm::cross(ab, ac));
  const T farthest = std::sqrt(std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)}));
  const T distance = T(6) * position_error + T(8) * std::numeric_limits<T>::epsilon() * farthest;
  // Over the heights of the corners above the edges that they are opposite to.
  const auto margin = [&](const Vec3<T>& edge) {
    const T wanted = distance * glm::length(edge);
    return wanted < twice_area / T(3) ? wanted / twice_area : T(0);
  };
  return {margin(bc), margin(ac), margin(ab)};
}

/// The largest of the three: no point whose coordinates are all above it needs to be moved.
template <std::floating_point T>
[[nodiscard]] inline T largest_edge_margin(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c,
                                           T position_error) noexcept {
  const Vec3<T> margins = edge_margins(a, b, c, position_error);
  return std::max({margins.x, margins.y, margins.z});
}

/// The barycentric coordinates `weights`, moved off the edges where they are too near to one.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> keep_off_edges(const Vec3<T>& weights, const Vec3<T>& a, const Vec3<T>& b,
                                            const Vec3<T>& c, T position_error) noexcept {
  const Vec3<T> margins = edge_margins(a, b, c, position_error);
  const Vec3<T> moved(std::max(weights.x, margins.x), std::max(weights.y, margins.y), std::max(weights.z, margins.z));
  return moved * (T(1) / (moved.x + moved.y + moved.z));
}

}  // namespace gmis::scene
