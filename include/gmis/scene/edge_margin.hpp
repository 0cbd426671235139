#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/ieee.hpp"
#include "gmis/core/math.hpp"

/// \file
/// A ray that leaves a triangle starts beside it, `position_error` away along the normal. Near an
/// edge this start may lie behind the adjacent triangle, and so may the point itself, which is
/// rounded along the triangle too: the ray then leaks into the volume that the two enclose, or out
/// of it. Points nearer to such an edge than a few of these errors are therefore moved to that
/// distance, within the triangle. No start is then on the wrong side where triangles meet at 20°
/// or more. Edges at which a surface goes on smoothly, or ends, are no such edges: there nothing is
/// moved. But a triangle may touch a sharp edge with a corner alone, as do the inner ones of a face
/// of many triangles or pieces. Its points at that corner are as near to the sharp edge as those
/// beside it. They are kept off both edges that end there: a ball within these is no nearer to what
/// passes outside.

namespace gmis::scene {

/// The edges of a triangle that points are kept off, because another triangle meets it there at an
/// angle, or because one end of the edge touches such an edge: bit k for the edge opposite to
/// corner k.
using SharpEdges = std::uint8_t;

/// Least barycentric coordinates, one per corner, that keep a point off the sharp edges; 0 for the
/// others, and where the triangle is too thin for that, a sliver of a few roundings: there, a point
/// would be moved along it to no avail.
template <std::floating_point T>
[[nodiscard]] inline Vec3<T> edge_margins(const std::array<Vec3<T>, 3>& corners, SharpEdges sharp, T position_error) {
  const auto& [a, b, c] = corners;
  const Vec3<T> ab = b - a, ac = c - a, bc = c - b;
  const T twice_area = glm::length(glm::cross(ab, ac));
  const T farthest = std::sqrt(std::max({glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)}));
  const T distance = T(6) * position_error + T(8) * std::numeric_limits<T>::epsilon() * farthest;
  // Over the heights of the corners above the edges that they are opposite to.
  const auto margin = [&](unsigned edge, const Vec3<T>& along) {
    const T wanted = distance * glm::length(along);
    return (sharp >> edge & 1U) != 0 && wanted < twice_area / T(3) ? wanted / twice_area : T(0);
  };
  return {margin(0, bc), margin(1, ac), margin(2, ab)};
}

/// The largest of the three: no point whose coordinates are all above it needs to be moved.
template <std::floating_point T>
[[nodiscard]] inline T largest_edge_margin(const std::array<Vec3<T>, 3>& corners, SharpEdges sharp, T position_error) {
  const Vec3<T> margins = edge_margins(corners, sharp, position_error);
  return std::max({margins.x, margins.y, margins.z});
}

/// The barycentric coordinates `weights`, moved off the sharp edges where they are too near to one.
/// Rarely needed, so it is not inlined.
template <std::floating_point T>
[[nodiscard]] GMIS_RARE Vec3<T> keep_off_edges(const Vec3<T>& weights, const std::array<Vec3<T>, 3>& corners,
                                               SharpEdges sharp, T position_error) {
  const Vec3<T> moved = glm::max(weights, edge_margins(corners, sharp, position_error));
  return moved * (T(1) / (moved.x + moved.y + moved.z));
}

/// The sharp edges of every triangle: those that have both ends in common with one of another
/// triangle, at an angle that matters for the errors of positions, and those at a corner that
/// touches a sharp edge of others. Which mesh a triangle is of makes no difference. Linear in the
/// number of triangles but for two sorts and a search at such corners.
template <std::floating_point T>
[[nodiscard]] std::vector<SharpEdges> find_sharp_edges(std::span<const std::array<Vec3<T>, 3>> triangles,
                                                       std::span<const T> position_errors) {
  struct Edge {
    std::uint64_t ends;  ///< a hash of the two
    std::uint32_t triangle, opposite;
  };
  const auto hash_of = [](const Vec3<T>& at) {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {  // + 0 makes one of both zeros
      hash = (hash ^ std::bit_cast<std::uint64_t>(static_cast<double>(at[axis]) + 0.0)) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29U;
    }
    return hash;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const std::array<std::uint64_t, 3> ends{hash_of(triangles[i][0]), hash_of(triangles[i][1]),
                                            hash_of(triangles[i][2])};
    for (std::uint32_t k = 0; k < 3; ++k) edges.push_back({ends[(k + 1) % 3] + ends[(k + 2) % 3], i, k});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.ends != b.ends ? a.ends < b.ends : 3ULL * a.triangle + a.opposite < 3ULL * b.triangle + b.opposite;
  });

  // From the edge into the triangle, perpendicular to it.
  const auto inward = [&](const Edge& edge) {
    const auto& corners = triangles[edge.triangle];
    const glm::dvec3 from(corners[(edge.opposite + 1) % 3]), to(corners[(edge.opposite + 2) % 3]);
    const auto unit = [](const glm::dvec3& v) { return v * ieee_divide(1.0, std::sqrt(glm::dot(v, v))); };
    const glm::dvec3 along = unit(to - from), up = glm::dvec3(corners[edge.opposite]) - from;
    return unit(up - along * glm::dot(up, along));  // not a number for a triangle without area
  };
  const auto is_sharp = [&](const Edge& edge, const glm::dvec3& here, const glm::dvec3& there) {
    const double cosine = -glm::dot(here, there);  // of the bend from the one to the other
    if (cosine < -0.985) return false;             // folded together: a point between them is nowhere off both
    if (cosine < 0.966) return true;               // 15°; several such bends around a corner make a point of it
    T farthest = 0;
    for (const Vec3<T>& corner : triangles[edge.triangle]) farthest = std::max(farthest, glm::length(corner));
    const double rounding = 4 * static_cast<double>(std::numeric_limits<T>::epsilon() * farthest);
    const double error = static_cast<double>(position_errors[edge.triangle]);
    return 2 * rounding * glm::length(glm::cross(here, there)) > error * cosine;
  };
  /// An end of a sharp edge, given by one of its triangles.
  struct SharpEnd {
    std::uint64_t at;  ///< a hash of the corner
    std::uint32_t triangle;
    std::uint8_t corner, other;  ///< of that triangle, at this end and at the other one
  };
  std::vector<SharpEnd> sharp_ends;
  constexpr std::size_t most = 8;  // of triangles at one edge that each is compared with
  std::vector<SharpEdges> result(triangles.size());
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].ends == edges[begin].ends) ++end;
    bool any_is_sharp = false;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = i + 1; j < std::min(end, i + most); ++j) {
        const glm::dvec3 one = inward(edges[i]), other = inward(edges[j]);
        for (const std::size_t edge : {i, j})
          if (is_sharp(edges[edge], one, other)) {
            result[edges[edge].triangle] |= static_cast<SharpEdges>(1U << edges[edge].opposite);
            any_is_sharp = true;
          }
      }
    if (!any_is_sharp) continue;
    const auto& [ends, triangle, opposite] = edges[begin];
    const auto a = static_cast<std::uint8_t>((opposite + 1) % 3), b = static_cast<std::uint8_t>((opposite + 2) % 3);
    sharp_ends.push_back({hash_of(triangles[triangle][a]), triangle, a, b});
    sharp_ends.push_back({hash_of(triangles[triangle][b]), triangle, b, a});
  }
  if (sharp_ends.empty()) return result;

  // Corners that touch a sharp edge of others.
  constexpr std::size_t most_compared = 64;  // of sharp edges at one corner; where there are more, one is near
  std::sort(sharp_ends.begin(), sharp_ends.end(), [](const SharpEnd& a, const SharpEnd& b) { return a.at < b.at; });
  const auto direction = [&](std::uint32_t triangle, std::size_t from, std::size_t to) {
    const glm::dvec3 along = glm::dvec3(triangles[triangle][to]) - glm::dvec3(triangles[triangle][from]);
    return along * ieee_divide(1.0, std::sqrt(glm::dot(along, along)));
  };
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const SharpEdges own = result[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
      const bool a_is_sharp = (own >> b & 1U) != 0, b_is_sharp = (own >> a & 1U) != 0;  // the edges to these corners
      if (a_is_sharp && b_is_sharp) continue;
      const std::uint64_t at = hash_of(triangles[i][k]);
      const auto less = [](const SharpEnd& sharp_end, std::uint64_t hash) { return sharp_end.at < hash; };
      auto sharp_end = std::lower_bound(sharp_ends.begin(), sharp_ends.end(), at, less);
      if (sharp_end == sharp_ends.end() || sharp_end->at != at) continue;
      if (!a_is_sharp && !b_is_sharp) {
        result[i] |= static_cast<SharpEdges>(1U << a | 1U << b);
        continue;
      }
      // Kept off one of its edges already, and so off sharp ones too, unless these are much nearer
      // to the other: less than half as far is less than the 2.75 errors that a start needs at 20°.
      const std::size_t sharp = a_is_sharp ? a : b, smooth = a_is_sharp ? b : a;
      const glm::dvec3 along = direction(i, k, smooth);
      const double sine = glm::length(glm::cross(along, direction(i, k, sharp)));
      std::size_t compared = 0;
      for (; sharp_end != sharp_ends.end() && sharp_end->at == at; ++sharp_end) {
        const glm::dvec3 other = direction(sharp_end->triangle, sharp_end->corner, sharp_end->other);
        const bool is_near = glm::dot(other, along) > 0.0 && glm::length(glm::cross(other, along)) < 0.5 * sine;
        if (!is_near && ++compared < most_compared) continue;
        result[i] |= static_cast<SharpEdges>(1U << sharp);  // the edge to `smooth`
        break;
      }
    }
  }
  return result;
}

}  // namespace gmis::scene
