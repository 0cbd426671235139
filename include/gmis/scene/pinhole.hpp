#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <limits>
#include <optional>
#include <stdexcept>

#include "gmis/core/concepts.hpp"

namespace gmis::scene {

/// Where a pinhole camera stands and what it sees, in double precision. Camera space has x to the right of the picture,
/// y up and z forward; `world_from_camera` may mirror but not shear.
struct PinholeDescription {
  glm::dmat4 world_from_camera{1};
  /// x0, x1, y0, y1 of the picture on the plane z = 1, y up.
  std::array<double, 4> window{-1, 1, -1, 1};
  glm::ivec2 resolution{512, 512};
};

/// Looks from `eye` at `target`; `field_of_view` in degrees across the shorter side of the picture.
[[nodiscard]] inline PinholeDescription look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                                                double field_of_view, glm::ivec2 resolution) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  const double half = std::tan(field_of_view * pi<double> / 360);
  const double aspect = static_cast<double>(resolution.x) / resolution.y;
  const double x = half * std::max(aspect, 1.0), y = half * std::max(1 / aspect, 1.0);
  const glm::dvec3 upward = glm::cross(right, forward);
  return {glm::dmat4(glm::dvec4(right, 0), glm::dvec4(upward, 0), glm::dvec4(forward, 0), glm::dvec4(eye, 1)),
          {-x, x, -y, y},
          resolution};
}

/// An ideal pinhole whose pixels average radiance over their square: meets `gmis::Camera`.
template <std::floating_point T = float>
class Pinhole {
 public:
  using Spectrum = Vec3<T>;

  /// `origin`: the point of the world that becomes 0, in double precision. Throws when the transform or the window is
  /// no camera.
  Pinhole(const PinholeDescription& from, const glm::dvec3& origin) : resolution_(from.resolution) {
    if (resolution_.x < 1 || resolution_.y < 1) throw std::invalid_argument("a camera needs at least one pixel");
    std::array<glm::dvec3, 3> axes{};
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 axis(from.world_from_camera[i]);
      const double length = glm::length(axis);
      if (!(length > 0 && length < std::numeric_limits<double>::infinity()))
        throw std::invalid_argument("the camera's transform is singular or not finite");
      axes[static_cast<std::size_t>(i)] = axis / length;
    }
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > 1e-6)
        throw std::invalid_argument(
            "the camera's transform shears: only rotation, translation, mirroring and scaling "
            "make a pinhole camera");
    const auto [x0, x1, y0, y1] = from.window;
    if (!(x0 < x1 && y0 < y1)) throw std::invalid_argument("the camera's window is empty");
    const double step_x = (x1 - x0) / resolution_.x, step_y = (y1 - y0) / resolution_.y;
    position_ = Vec3<T>(glm::dvec3(from.world_from_camera[3]) - origin);
    corner_ = Vec3<T>(axes[2] + axes[0] * x0 + axes[1] * y1);
    right_step_ = Vec3<T>(axes[0] * step_x);
    down_step_ = Vec3<T>(axes[1] * -step_y);
    forward_ = Vec3<T>(axes[2]);
    // Dot products with these give pixel coordinates times depth.
    to_column_ = Vec3<T>(axes[0] / step_x - axes[2] * (x0 / step_x));
    to_row_ = Vec3<T>(axes[1] / -step_y + axes[2] * (y1 / step_y));
    inverse_pixel_area_ = static_cast<T>(1 / (step_x * step_y));
  }

  [[nodiscard]] glm::ivec2 resolution() const noexcept { return resolution_; }
  [[nodiscard]] bool has_parallel_rays() const noexcept { return false; }
  [[nodiscard]] const Vec3<T>& position() const noexcept { return position_; }

  [[nodiscard]] std::optional<CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const Vec2<T>& uv_pixel,
                                                                 const Vec2<T>&) const noexcept {
    const Vec3<T> unnormalised = corner_ + right_step_ * (static_cast<T>(pixel.x) + uv_pixel.x) +
                                 down_step_ * (static_cast<T>(pixel.y) + uv_pixel.y);
    const T length2 = glm::dot(unnormalised, unnormalised);
    const T length = std::sqrt(length2);
    return CameraSample<Spectrum>{{position_, {}, {}, T(0)},
                                  unnormalised * (T(1) / length),
                                  Spectrum(T(1)),
                                  inverse_pixel_area_ * length2 * length};
  }

  [[nodiscard]] std::optional<CameraProjection<Spectrum>> project(const Vec3<T>& point, const Vec2<T>&) const noexcept {
    const Vec3<T> offset = point - position_;
    const T depth = glm::dot(offset, forward_);
    if (!(depth > T(0))) return std::nullopt;
    const T inverse_depth = T(1) / depth;
    const T column = glm::dot(offset, to_column_) * inverse_depth;
    const T row = glm::dot(offset, to_row_) * inverse_depth;
    if (!(column >= T(0) && row >= T(0) && column < static_cast<T>(resolution_.x) &&
          row < static_cast<T>(resolution_.y)))
      return std::nullopt;
    const T distance = std::sqrt(glm::dot(offset, offset));
    const T inverse_cos = distance * inverse_depth;
    return CameraProjection<Spectrum>{{static_cast<int>(column), static_cast<int>(row)},
                                      {position_, {}, {}, T(0)},
                                      offset * (T(-1) / distance),
                                      Spectrum(T(1)),
                                      inverse_pixel_area_ * inverse_cos * inverse_cos * inverse_cos};
  }

 private:
  glm::ivec2 resolution_;
  Vec3<T> position_{}, corner_{}, right_step_{}, down_step_{}, forward_{}, to_column_{}, to_row_{};
  T inverse_pixel_area_{};
};

static_assert(Camera<Pinhole<float>>);
static_assert(Camera<Pinhole<double>>);

}  // namespace gmis::scene
