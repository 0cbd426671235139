#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "gmis/core/cos_sin.hpp"
#include "gmis/core/math.hpp"

namespace gmis {

/// A distribution of lines that pass near a centre. The distance b of a line from the centre lies
/// in one of 16 rings [ρ_k, ρ_{k+1}) with the same probability. Within a ring, directions from a
/// point are uniform per steradian, and parallel lines are uniform per area perpendicular to them.
/// So the distribution fits any scale: a point a million radii away, too.
template <std::floating_point T>
class Aim {
 public:
  static constexpr std::size_t rings = 16;  ///< number of rings
  /// ρ_0 … ρ_16, increasing from ρ_0 = 0.
  using Radii = std::array<T, rings + 1>;

  /// Aims at nothing: its densities are 0.
  Aim() = default;
  /// `radii` must increase from 0.
  Aim(const Vec3<T>& centre, const Radii& radii) noexcept : centre_(centre), radii_(radii) {
    for (std::size_t k = 0; k < squares_.size(); ++k) squares_[k] = square(radii[k]);
  }

  /// The centre that the lines pass near.
  [[nodiscard]] const Vec3<T>& centre() const noexcept { return centre_; }
  /// The bounds of the rings.
  [[nodiscard]] const Radii& radii() const noexcept { return radii_; }

  /// A direction from `point` towards the centre, at most 90° off. Nothing when `point` is nearer
  /// to the centre than the chosen ring, with the probability `failure(point)`.
  [[nodiscard]] std::optional<Vec3<T>> sample_direction(const Vec3<T>& point, const Vec2<T>& u) const noexcept {
    const Vec3<T> offset = centre_ - point;
    const T distance_squared = glm::dot(offset, offset);
    const Ring ring = pick(u.x);
    if (!(squares_[ring.number] < distance_squared)) return std::nullopt;
    const T from = drop(ring.number, distance_squared), to = drop(ring.number + 1, distance_squared);
    const T below = from + (to - from) * ring.rest;  // 1 − cos θ
    const T sine = sqrt_or_zero(below * (T(2) - below));
    const auto turn = cos_sin_of_turns(u.y);
    return Frame<T>::around(offset * (T(1) / std::sqrt(distance_squared)))
        .to_world({sine * turn.cos, sine * turn.sin, T(1) - below});
  }
  /// Probability with which `sample_direction(point, ·)` gives nothing.
  [[nodiscard]] T failure(const Vec3<T>& point) const noexcept {
    const Vec3<T> offset = centre_ - point;
    const T distance_squared = glm::dot(offset, offset);
    const auto reached = std::lower_bound(squares_.begin(), squares_.end() - 1, distance_squared) - squares_.begin();
    return T(rings - static_cast<std::size_t>(reached)) / T(rings);
  }
  /// Density per steradian of `sample_direction(point, ·)` for the unit `direction` of the line
  /// through `on_line`. The line must also pass through `point`; `on_line`, which is nearer to the
  /// centre, gives the distance of the line more exactly.
  [[nodiscard]] T direction_density(const Vec3<T>& point, const Vec3<T>& direction,
                                    const Vec3<T>& on_line) const noexcept {
    const Vec3<T> offset = centre_ - point;
    if (!(glm::dot(offset, direction) > T(0))) return T(0);
    const std::size_t ring = ring_of(on_line, direction);
    const T distance_squared = glm::dot(offset, offset);
    if (ring == rings || !(squares_[ring] < distance_squared)) return T(0);
    return T(1) / (T(2) * pi<T> * T(rings) * (drop(ring + 1, distance_squared) - drop(ring, distance_squared)));
  }

  /// A point of a line with the unit `direction`, in the plane through the centre.
  [[nodiscard]] Vec3<T> sample_line(const Vec3<T>& direction, const Vec2<T>& u) const noexcept {
    const Ring ring = pick(u.x);
    const T from = squares_[ring.number], to = squares_[ring.number + 1];
    const T distance = std::sqrt(from + (to - from) * ring.rest);
    const auto turn = cos_sin_of_turns(u.y);
    const Frame<T> frame = Frame<T>::around(direction);
    return centre_ + (frame.tangent * turn.cos + frame.bitangent * turn.sin) * distance;
  }
  /// Density of `sample_line(direction, ·)` per area perpendicular to `direction`, for the line
  /// through `on_line`.
  [[nodiscard]] T line_density(const Vec3<T>& direction, const Vec3<T>& on_line) const noexcept {
    const std::size_t ring = ring_of(on_line, direction);
    if (ring == rings) return T(0);
    return T(1) / (pi<T> * T(rings) * (squares_[ring + 1] - squares_[ring]));
  }

 private:
  struct Ring {
    std::size_t number;
    T rest;  ///< in [0, 1)
  };
  [[nodiscard]] static Ring pick(T u) noexcept {
    const T scaled = u * T(rings);
    const auto number = std::min(static_cast<std::size_t>(scaled), rings - 1);
    return {number, scaled - T(number)};
  }
  /// The ring of the line through `on_line`; `rings` outside of all.
  [[nodiscard]] std::size_t ring_of(const Vec3<T>& on_line, const Vec3<T>& direction) const noexcept {
    const Vec3<T> across = glm::cross(centre_ - on_line, direction);
    const T distance_squared = glm::dot(across, across);
    return static_cast<std::size_t>(std::upper_bound(squares_.begin() + 1, squares_.end(), distance_squared) -
                                    (squares_.begin() + 1));
  }
  /// 1 − cos of the half angle of the ball with radius ρ_k; 1 for a radius above the distance.
  [[nodiscard]] T drop(std::size_t k, T distance_squared) const noexcept {
    const T sine_squared = std::min(T(1), squares_[k] / distance_squared);
    return sine_squared / (T(1) + std::sqrt(T(1) - sine_squared));
  }

  Vec3<T> centre_{T(0)};
  Radii radii_{}, squares_{};
};

}  // namespace gmis
