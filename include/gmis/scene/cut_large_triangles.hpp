#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>

#include "gmis/core/math.hpp"

/// \file
/// A ray that leaves a triangle starts beside it, further away the larger the triangle is
/// (`position_error`). On a ground plane twenty thousand units wide that is a twentieth of a unit:
/// it would pass over, or start inside, what lies on the ground before the camera. Triangles much
/// larger than their distance from the camera, which is at 0, are therefore cut into pieces that
/// are smaller the nearer they are.
///
/// Whether an edge is cut, and where, depends on its two ends alone, so that the pieces of
/// neighbours share their corners and no ray passes between them.

namespace gmis::scene {

/// A part of a triangle.
struct TrianglePiece {
  std::array<glm::dvec3, 3> corners{};  ///< in the order of the triangle's own
  glm::dmat3 weights{1};                ///< column k: barycentric weights of corner k in the whole triangle
};

/// Cuts triangles that are large and near.
class LargeTriangleCutter {
 public:
  /// An edge may be as long as `largest_size` times its distance from 0; distances below
  /// `least_distance` count as `least_distance`.
  constexpr LargeTriangleCutter(double largest_size, double least_distance) noexcept
      : largest_size_(largest_size), least_distance_(least_distance) {}

  /// For coordinates in T, none above `farthest`: rays start at most about 5e-5 of the distance
  /// from the camera beside a surface, which for double is never worth a cut.
  template <std::floating_point T>
  [[nodiscard]] static constexpr LargeTriangleCutter for_precision(double farthest) noexcept {
    constexpr double unit = static_cast<double>(std::numeric_limits<T>::epsilon());
    constexpr double error = 5e-5, roundings = 20;  // of the extent of a triangle, as in its position error
    return {error / (roundings * unit), 16 * unit * farthest};
  }

  /// Calls `visit(const TrianglePiece&)` for all pieces of a triangle, which tile it; for the
  /// triangle itself where it need not be cut.
  template <class Visit>
  void for_each_piece(const std::array<glm::dvec3, 3>& triangle, Visit&& visit) const {
    cut({triangle, glm::dmat3(1)}, visit, 0, false);
  }

 private:
  static constexpr int most_cuts = 256;  // one after the other

  template <class Visit>
  void cut(const TrianglePiece& piece, Visit& visit, int cuts, bool is_cut_inside) const {
    const auto& corners = piece.corners;
    const auto end = [&](std::size_t edge, std::size_t which) { return corners[(edge + 1 + which) % 3]; };
    const std::array<double, 3> lengths{glm::length(end(0, 1) - end(0, 0)), glm::length(end(1, 1) - end(1, 0)),
                                        glm::length(end(2, 1) - end(2, 0))};
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    // No point is nearer than this. Nearly all triangles end here.
    const double nearest = glm::length(corners[0]) - longest;
    if (longest <= largest_size_ * std::max(nearest, least_distance_) || cuts == most_cuts) return visit(piece);

    std::size_t longest_marked = 3;
    for (std::size_t edge = 0; edge < 3; ++edge)
      if (is_too_long(end(edge, 0), end(edge, 1)) && (longest_marked == 3 || lengths[edge] > lengths[longest_marked]))
        longest_marked = edge;
    if (longest_marked < 3) {
      const std::size_t a = (longest_marked + 1) % 3, b = (longest_marked + 2) % 3;
      const glm::dvec3 middle = (corners[a] + corners[b]) * 0.5;
      const auto weights = (column(piece.weights, a) + column(piece.weights, b)) * 0.5;
      for (const std::size_t replaced : {b, a})
        cut(with_corner(piece, replaced, middle, weights), visit, cuts + 1, is_cut_inside);
      return;
    }
    // All edges are far, but the triangle passes near 0: it is cut at the point that is nearest,
    // but not nearer to an edge than leaves the pieces an area in T. Once is enough: pieces with
    // that corner are about as far as their edges. A thin triangle is, too, and has little to gain:
    // hence 1.5.
    if (is_cut_inside) return visit(piece);
    glm::dvec3 foot = glm::max(foot_of_perpendicular(corners), glm::dvec3(1.0 / (largest_size_ * largest_size_)));
    foot /= foot[0] + foot[1] + foot[2];
    const glm::dvec3 point = corners[0] * foot[0] + corners[1] * foot[1] + corners[2] * foot[2];
    if (longest <= 1.5 * largest_size_ * std::max(glm::length(point), least_distance_)) return visit(piece);
    const glm::dvec3 weights = piece.weights * foot;
    for (std::size_t replaced = 0; replaced < 3; ++replaced)
      cut(with_corner(piece, replaced, point, weights), visit, cuts + 1, true);
  }

  [[nodiscard]] static glm::dvec3 column(const glm::dmat3& m, std::size_t k) noexcept { return m[static_cast<int>(k)]; }
  [[nodiscard]] static TrianglePiece with_corner(TrianglePiece piece, std::size_t k, const glm::dvec3& corner,
                                                 const glm::dvec3& weights) noexcept {
    piece.corners[k] = corner;
    piece.weights[static_cast<int>(k)] = weights;
    return piece;
  }

  /// True when the edge from a to b is too long for its distance; the result does not depend on the
  /// order of a and b.
  [[nodiscard]] bool is_too_long(glm::dvec3 a, glm::dvec3 b) const noexcept {
    const auto key = [](const glm::dvec3& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
    if (key(b) < key(a)) std::swap(a, b);
    const glm::dvec3 along = b - a;
    const double length2 = glm::dot(along, along);
    if (!(length2 > 0.0)) return false;
    const double t = std::clamp(-glm::dot(a, along) / length2, 0.0, 1.0);
    return std::sqrt(length2) > largest_size_ * std::max(glm::length(a + along * t), least_distance_);
  }

  /// Barycentric weights of the point of the triangle's plane that is nearest to 0; all 0 for a
  /// triangle without area.
  [[nodiscard]] static glm::dvec3 foot_of_perpendicular(const std::array<glm::dvec3, 3>& corners) noexcept {
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double area2 = glm::dot(normal, normal);
    if (!(area2 > 0.0)) return glm::dvec3(0.0);
    const auto weight = [&](std::size_t a, std::size_t b) {
      return glm::dot(glm::cross(corners[a], corners[b]), normal) / area2;
    };
    return {weight(1, 2), weight(2, 0), weight(0, 1)};
  }

  double largest_size_, least_distance_;
};

}  // namespace gmis::scene
