#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>

#include "gmis/check/compare.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"

namespace gmis {

namespace detail {
/// The density of a camera ray is 1 / |∂x/∂u × ∂x/∂v|, with x the direction or, for parallel rays,
/// the origin.
template <Camera C, class T>
void check_camera_density(const C& camera, glm::ivec2 pixel, const Vec2<T>& uv, const Vec2<T>& lens,
                          const CameraSample<typename C::Spectrum>& ray, Findings& findings) {
  using V = Vec3<double>;
  const bool is_parallel = camera.has_parallel_rays();
  const auto place = [&](T u, T v) -> V {
    const auto sample = camera.sample_ray(pixel, {u, v}, lens);
    if (!sample) return V(std::numeric_limits<double>::quiet_NaN());
    return is_parallel ? V(sample->origin.position) : V(sample->direction);
  };
  const T step = T(0.15);
  const V along_u = (place(uv.x + step, uv.y) - place(uv.x - step, uv.y)) / (2.0 * static_cast<double>(step));
  const V along_v = (place(uv.x, uv.y + step) - place(uv.x, uv.y - step)) / (2.0 * static_cast<double>(step));
  const double area = glm::length(glm::cross(along_u, along_v));
  if (!std::isfinite(area)) return;
  const double magnitude = is_parallel ? glm::length(V(ray.origin.position)) : 1.0;
  const double rounding =
      8.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * magnitude / std::sqrt(std::max(area, 1e-30));
  if (rounding > 0.05) return;  // a pixel too small for these differences to say anything
  compare(findings, Convention::camera_density, static_cast<double>(ray.density), 1.0 / area, 0.05 + 2.0 * rounding);
}
}  // namespace detail

/// Checks your own camera: rays through pixels, projections, densities. `distance`: how far
/// the scene is, in scene units.
template <Camera C, UniformSource Source>
[[nodiscard]] Findings check_camera(const C& camera, Source& source, double distance = 1.0, std::size_t rays = 512) {
  using S = typename C::Spectrum;
  using T = ScalarOf<S>;
  using V = Vec3<double>;
  Findings findings;
  const glm::ivec2 size = camera.resolution();
  const double radius = filter_radius_of(camera);
  const auto inside = [&source](double margin) {
    return static_cast<T>(margin + (1.0 - 2.0 * margin) * uniform<double>(source));
  };
  for (std::size_t i = 0; i < rays; ++i) {
    const glm::ivec2 pixel{static_cast<int>(uniform<double>(source) * size.x),
                           static_cast<int>(uniform<double>(source) * size.y)};
    const Vec2<T> uv{inside(0.2), inside(0.2)}, lens{inside(0.0), inside(0.0)};
    const auto ray = camera.sample_ray(pixel, uv, lens);
    if (!ray) continue;
    const V direction(ray->direction), origin(ray->origin.position);
    findings.look_at(0, {origin, V(0), direction});
    detail::compare(findings, Convention::camera_ray_unit, glm::length(direction), 1.0, 1e-3);

    // A point on the ray must project to the pixel, as seen from the same point of the lens.
    const double t = distance * (0.2 + 2.0 * uniform<double>(source));
    const Vec3<T> point(origin + t * direction);
    const auto seen = camera.project(point, lens);
    // Within a filter wider than a pixel, a point is seen by the pixels around, those outside of
    // the picture included.
    const int reach = static_cast<int>(std::ceil(2.0 * radius)) - 1;
    const bool is_near_border = std::min({pixel.x, pixel.y, size.x - 1 - pixel.x, size.y - 1 - pixel.y}) < reach;
    if (!seen) {
      if (!is_near_border) findings.count(Convention::camera_pixel, false);
    } else if (const V offset = V(seen->origin.position) - origin; glm::length(offset) <= 1e-3 * t) {
      findings.count(Convention::camera_pixel,
                     std::abs(seen->pixel.x - pixel.x) <= reach && std::abs(seen->pixel.y - pixel.y) <= reach);
      const V to_camera(seen->to_camera);
      findings.count(Convention::camera_to_camera, glm::length(to_camera + direction) <= 0.02);
      detail::compare(findings, Convention::camera_two_densities, static_cast<double>(seen->density),
                      static_cast<double>(ray->density));
      detail::compare_channels(findings, Convention::camera_two_weights, seen->weight, ray->weight, 1.0, 0.01);
    }

    if (radius <= 0.5) detail::check_camera_density(camera, pixel, uv, lens, *ray, findings);
  }
  return findings;
}

}  // namespace gmis
