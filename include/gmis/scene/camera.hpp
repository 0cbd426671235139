#pragma once

#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <limits>
#include <optional>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/warp.hpp"

namespace gmis::scene {

enum class Projection : std::uint8_t { perspective, orthographic };

/// Position and view of a camera, in double precision. Camera space has x to the right of the
/// picture, y up and z forward. `world_from_camera` may mirror and stretch along these axes, but
/// not shear.
struct CameraDescription {
  glm::dmat4 world_from_camera{1};  ///< columns: x to the right, y up, z forward, position
  /// x0, x1, y0, y1 of the picture in camera space, y up: on the plane z = 1 in perspective, on
  /// every plane z = const in an orthographic projection.
  std::array<double, 4> window{-1, 1, -1, 1};
  glm::ivec2 resolution{512, 512};                  ///< in pixels
  Projection projection = Projection::perspective;  ///< perspective, or parallel rays
  double lens_radius = 0;     ///< radius of a thin lens in camera space; 0 is a pinhole; must be 0 when orthographic
  double focal_distance = 1;  ///< in camera space: points on the plane z = `focal_distance` are sharp
};

/// A pinhole camera at `eye` that looks at `target`. `field_of_view` is in degrees across the
/// shorter side of the picture.
[[nodiscard]] inline CameraDescription look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                                               double field_of_view, glm::ivec2 resolution) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  const double half = std::tan(field_of_view * pi<double> / 360);
  const double aspect = static_cast<double>(resolution.x) / resolution.y;
  const double x = half * std::max(aspect, 1.0), y = half * std::max(1 / aspect, 1.0);
  const glm::dvec3 upward = glm::cross(right, forward);
  CameraDescription result;
  result.world_from_camera =
      glm::dmat4(glm::dvec4(right, 0), glm::dvec4(upward, 0), glm::dvec4(forward, 0), glm::dvec4(eye, 1));
  result.window = {-x, x, -y, y};
  result.resolution = resolution;
  return result;
}

/// A camera with a pinhole, a thin lens or parallel rays. The value of a pixel is the mean radiance
/// over the square of the pixel and over the lens. Models `gmis::Camera`.
///
/// The point on the lens is uniform in every technique. All densities are conditional on this
/// point, because its own density is the same for every technique and cancels. Light subpaths never
/// hit the lens: camera subpaths and splats make all paths.
///
/// The radiance is that in the medium in which the camera stands. Refraction scales radiance by the
/// square of the relative index along the path, so the camera applies no further factor.
template <std::floating_point T = float>
class Camera {
 public:
  using Spectrum = Vec3<T>;

  /// `origin` is the point of the world that becomes 0, in double precision. Throws
  /// `std::invalid_argument` when the description is invalid.
  Camera(const CameraDescription& from, const glm::dvec3& origin)
      : resolution_(from.resolution), is_orthographic_(from.projection == Projection::orthographic) {
    if (resolution_.x < 1 || resolution_.y < 1) reject_argument("a camera needs at least one pixel");
    std::array<glm::dvec3, 3> axes{};
    std::array<double, 3> stretch{};
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 axis(from.world_from_camera[static_cast<int>(i)]);
      stretch[i] = glm::length(axis);
      if (!(stretch[i] > 0 && stretch[i] < std::numeric_limits<double>::infinity()))
        reject_argument("the camera's transform is singular or not finite");
      axes[i] = axis / stretch[i];
    }
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > 1e-6)
        reject_argument(
            "the camera's transform shears: only rotation, translation, mirroring and scaling make a camera");
    if (!(from.window[0] < from.window[1] && from.window[2] < from.window[3]))
      reject_argument("the camera's window is empty");
    for (const double side : from.window)
      if (!(std::abs(side) < std::numeric_limits<double>::infinity()))
        reject_argument("the camera's window is not finite");
    if (!(from.lens_radius >= 0 && from.lens_radius < std::numeric_limits<double>::infinity()))
      reject_argument("the radius of a lens must be finite and not negative");
    if (from.lens_radius > 0 && is_orthographic_) reject_argument("a camera with parallel rays has no lens");
    if (from.lens_radius > 0 && !(from.focal_distance > 0)) reject_argument("the focal distance must be above 0");

    // Window on the plane at distance 1 in perspective; in world units when rays are parallel.
    const double unit = is_orthographic_ ? 1 : stretch[2];
    const double x0 = from.window[0] * stretch[0] / unit, x1 = from.window[1] * stretch[0] / unit;
    const double y0 = from.window[2] * stretch[1] / unit, y1 = from.window[3] * stretch[1] / unit;
    const double step_x = (x1 - x0) / resolution_.x, step_y = (y1 - y0) / resolution_.y;
    const double depth = is_orthographic_ ? 0 : 1;
    position_ = Vec3<T>(glm::dvec3(from.world_from_camera[3]) - origin);
    corner_ = Vec3<T>(axes[2] * depth + axes[0] * x0 + axes[1] * y1);
    right_step_ = Vec3<T>(axes[0] * step_x);
    down_step_ = Vec3<T>(axes[1] * -step_y);
    forward_ = Vec3<T>(axes[2]);
    // The dot product of an offset with these vectors is a pixel coordinate (in perspective: times
    // the depth).
    to_column_ = Vec3<T>(axes[0] / step_x - axes[2] * (depth * x0 / step_x));
    to_row_ = Vec3<T>(axes[1] / -step_y + axes[2] * (depth * y1 / step_y));
    first_column_ = static_cast<T>(x0 / step_x);
    first_row_ = static_cast<T>(-y1 / step_y);
    inverse_pixel_area_ = static_cast<T>(1 / (step_x * step_y));
    has_lens_ = from.lens_radius > 0;
    if (has_lens_) {
      lens_x_ = Vec3<T>(axes[0] * (from.lens_radius * stretch[0]));
      lens_y_ = Vec3<T>(axes[1] * (from.lens_radius * stretch[1]));
      inverse_focal_distance_ = static_cast<T>(1 / (from.focal_distance * stretch[2]));
    }
  }

  /// In pixels.
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return resolution_; }
  [[nodiscard]] bool has_parallel_rays() const noexcept { return is_orthographic_; }
  [[nodiscard]] bool has_lens() const noexcept { return has_lens_; }
  /// The pinhole, the centre of the lens, or the point (0, 0) of an orthographic window.
  [[nodiscard]] const Vec3<T>& position() const noexcept { return position_; }

  /// A ray through `pixel`, uniform over the pixel's square and the lens. Its density per steradian
  /// is 1 / (A cos³ θ), with A the area of a pixel on the plane at distance 1; with parallel rays
  /// it is 1 / A per area. Never fails.
  [[nodiscard]] std::optional<CameraSample<Spectrum>> sample_ray(glm::ivec2 pixel, const Vec2<T>& uv_pixel,
                                                                 const Vec2<T>& uv_lens) const noexcept {
    const Vec3<T> place = corner_ + right_step_ * (static_cast<T>(pixel.x) + uv_pixel.x) +
                          down_step_ * (static_cast<T>(pixel.y) + uv_pixel.y);
    if (is_orthographic_)
      return CameraSample<Spectrum>{at(position_ + place), forward_, Spectrum(T(1)), inverse_pixel_area_};
    const Vec3<T> lens = lens_point(uv_lens);
    // Direction to the point on the plane of focus, with all lengths divided by the distance of
    // that plane.
    const Vec3<T> unnormalised = place - lens * inverse_focal_distance_;
    const T length2 = glm::dot(unnormalised, unnormalised);
    const T length = std::sqrt(length2);
    return CameraSample<Spectrum>{at(position_ + lens), unnormalised * (T(1) / length), Spectrum(T(1)),
                                  inverse_pixel_area_ * length2 * length};
  }

  /// The pixel that sees `point` through the lens point of `uv_lens`; nothing when `point` is
  /// behind the camera or outside the picture. Density as in `sample_ray`.
  [[nodiscard]] std::optional<CameraProjection<Spectrum>> project(const Vec3<T>& point,
                                                                  const Vec2<T>& uv_lens) const noexcept {
    const Vec3<T> lens = lens_point(uv_lens);
    const Vec3<T> offset = point - position_ - lens;
    const T depth = glm::dot(offset, forward_);
    if (!(depth > T(0))) return std::nullopt;
    T column = glm::dot(offset, to_column_);
    T row = glm::dot(offset, to_row_);
    const T inverse_depth = T(1) / depth;
    if (is_orthographic_) {
      column -= first_column_;
      row -= first_row_;
    } else {
      column *= inverse_depth;
      row *= inverse_depth;
    }
    if (has_lens_) {
      // Pixel coordinates of the point where the ray meets the plane of focus, seen from the centre
      // of the lens.
      column += glm::dot(lens, to_column_) * inverse_focal_distance_;
      row += glm::dot(lens, to_row_) * inverse_focal_distance_;
    }
    if (!(column >= T(0) && row >= T(0) && column < static_cast<T>(resolution_.x) &&
          row < static_cast<T>(resolution_.y)))
      return std::nullopt;
    const glm::ivec2 pixel(static_cast<int>(column), static_cast<int>(row));
    if (is_orthographic_)
      return CameraProjection<Spectrum>{pixel, at(point - forward_ * depth), -forward_, Spectrum(T(1)),
                                        inverse_pixel_area_};
    const T distance = std::sqrt(glm::dot(offset, offset));
    const T inverse_cos = distance * inverse_depth;
    return CameraProjection<Spectrum>{pixel, at(position_ + lens), offset * (T(-1) / distance), Spectrum(T(1)),
                                      inverse_pixel_area_ * inverse_cos * inverse_cos * inverse_cos};
  }

 private:
  [[nodiscard]] static SurfacePoint<T> at(const Vec3<T>& position) noexcept { return {position, {}, {}, T(0)}; }
  [[nodiscard]] Vec3<T> lens_point(const Vec2<T>& uv) const noexcept {
    if (!has_lens_) return Vec3<T>(T(0));
    const Vec2<T> disk = square_to_disk(uv);
    return lens_x_ * disk.x + lens_y_ * disk.y;
  }

  glm::ivec2 resolution_;
  bool is_orthographic_;
  bool has_lens_ = false;
  Vec3<T> position_{}, corner_{}, right_step_{}, down_step_{}, forward_{}, to_column_{}, to_row_{};
  Vec3<T> lens_x_{}, lens_y_{};
  T inverse_focal_distance_ = 0;
  T first_column_ = 0, first_row_ = 0;
  T inverse_pixel_area_{};
};

static_assert(gmis::Camera<Camera<float>>);
static_assert(gmis::Camera<Camera<double>>);

}  // namespace gmis::scene
