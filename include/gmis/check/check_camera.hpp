#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "gmis/check/compare.hpp"
#include "gmis/core/concepts.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/mis/moments.hpp"

namespace gmis {

namespace detail {
/// The place of a ray among those of other pixels: its direction or, for parallel rays, its origin.
/// NaN for a sample that failed.
template <Camera C>
[[nodiscard]] Vec3<double> place_of(const C& camera, const std::optional<CameraSample<typename C::Spectrum>>& ray) {
  if (!ray) return Vec3<double>(std::numeric_limits<double>::quiet_NaN());
  return Vec3<double>(camera.has_parallel_rays() ? ray->origin.position : ray->direction);
}

/// Bound on the relative error by rounding of the differences between places that lie `width`
/// apart.
template <std::floating_point T>
[[nodiscard]] double rounding_of(const Vec3<double>& place, double width) noexcept {
  return 8.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * glm::length(place) / std::max(width, 1e-15);
}
/// Relative rounding error above which differences say nothing: the pixel is too small.
inline constexpr double most_rounding = 0.05;

/// The density of a camera ray is 1 / |∂x/∂u × ∂x/∂v|, with x its place.
template <Camera C, class T>
void check_camera_density(const C& camera, glm::ivec2 pixel, const Vec2<T>& uv, const Vec2<T>& lens,
                          const CameraSample<typename C::Spectrum>& ray, Findings& findings) {
  using V = Vec3<double>;
  const auto place = [&](T u, T v) { return place_of(camera, camera.sample_ray(pixel, {u, v}, lens)); };
  const T step = T(0.15);
  const V along_u = (place(uv.x + step, uv.y) - place(uv.x - step, uv.y)) / (2.0 * static_cast<double>(step));
  const V along_v = (place(uv.x, uv.y + step) - place(uv.x, uv.y - step)) / (2.0 * static_cast<double>(step));
  const double area = glm::length(glm::cross(along_u, along_v));
  if (!std::isfinite(area)) return;
  const double rounding = rounding_of<T>(place_of(camera, std::optional(ray)), std::sqrt(area));
  if (rounding > most_rounding) return;
  compare(findings, Convention::camera_density, static_cast<double>(ray.density), 1.0 / area, 0.05 + 2.0 * rounding);
}

/// Rays of one pixel, and its size as the pixels beside it tell.
template <Camera C>
struct PixelRays {
  using V = Vec3<double>;

  std::vector<CameraSample<typename C::Spectrum>> rays;
  std::vector<V> places;
  V middle{0}, column{0}, row{0};  ///< mean place, and the steps to the next pixel in x and in y
  double box = 0.0;                ///< mean density of the rays of a box filter
  Moments<double> quotient;        ///< of that density and the one stated

  /// Draws rays, stratified. There are none when the camera cannot make one of them.
  template <class T>
  PixelRays(const C& camera, glm::ivec2 pixel, const Vec2<T>& lens, UniformSource auto& source) {
    constexpr int side = 8, count = side * side;
    for (int i = 0; i < count; ++i) {
      const T u = (static_cast<T>(i % side) + uniform<T>(source)) / T(side);
      const T v = (static_cast<T>(i / side) + uniform<T>(source)) / T(side);
      const auto ray_beside = [&](int x, int y) { return camera.sample_ray(pixel + glm::ivec2(x, y), {u, v}, lens); };
      const auto step = [&](int x, int y) {
        return 0.5 * (place_of(camera, ray_beside(x, y)) - place_of(camera, ray_beside(-x, -y)));
      };
      const auto ray = ray_beside(0, 0);
      const V along_x = step(1, 0), along_y = step(0, 1);
      const double density = 1.0 / glm::length(glm::cross(along_x, along_y));
      if (!ray || !std::isfinite(density) || !(ray->density > T(0))) {
        rays.clear();
        return;
      }
      rays.push_back(*ray);
      places.push_back(place_of(camera, ray));
      middle += places.back() / double{count};
      column += along_x / double{count};
      row += along_y / double{count};
      box += density / count;
      quotient.add(density / static_cast<double>(ray->density));
    }
  }

  /// From the middle to a place, in pixels.
  [[nodiscard]] Vec2<double> offset(const V& place) const {
    const double xx = glm::dot(column, column), xy = glm::dot(column, row), yy = glm::dot(row, row);
    const double x = glm::dot(place - middle, column), y = glm::dot(place - middle, row);
    return Vec2<double>(yy * x - xy * y, xx * y - xy * x) / (xx * yy - xy * xy);
  }
};

/// Checks a camera whose filter h is wider than a pixel. The points x of the film that the rays of
/// a pixel p pass have the density h(x − c_p); H(x) is the sum of that over all pixels.
///
/// Both members state the density of a box filter times H. As ∫ h/H = 1 for each pixel, the
/// quotient of the two densities has the mean 1 over the rays of a pixel.
///
/// The pixel q that `project` returns for x has the probability h(x − c_q) / H(x), and so has p
/// once x is known. The two are exchangeable, so these have the mean 0: q − p and
/// |x − c_q|² − |x − c_p|².
template <Camera C, UniformSource Source>
void check_wide_filter(const C& camera, double distance, Source& source, Findings& findings) {
  using T = ScalarOf<typename C::Spectrum>;
  using V = Vec3<double>;
  constexpr int pixels = 64;
  constexpr double level = 1e-9;  // of a false alarm, for each of three means
  // Away from the border all pixels that see a point are inside.
  const int margin = static_cast<int>(std::ceil(2.0 * filter_radius_of(camera)));
  const glm::ivec2 inner = glm::ivec2(camera.resolution()) - 2 * margin;
  if (inner.x < 1 || inner.y < 1) return;
  const auto below = [&source](int count) {
    return static_cast<int>(uniform_index(source, static_cast<std::uint32_t>(count)));
  };
  Moments<double> shift_x, shift_y, farther, to_p, to_q;
  for (int k = 0; k < pixels; ++k) {
    const glm::ivec2 pixel(margin + below(inner.x), margin + below(inner.y));
    const auto [u, v, share] = uniforms<T, 3>(source);
    const PixelRays<C> here(camera, pixel, Vec2<T>{u, v}, source);
    const double width = 1.0 / std::sqrt(here.box), rounding = rounding_of<T>(here.middle, width);
    if (here.rays.empty() || rounding > most_rounding) continue;
    findings.look_at(0, {V(here.rays[0].origin.position), V(0), V(here.rays[0].direction)});
    // A pixel is not flat: differences over two of them are off by a part of their squared angle.
    const double flatness = camera.has_parallel_rays() ? 0.0 : width * width;
    const double mean = here.quotient.mean();
    const double noise = std::sqrt(here.quotient.variance() / static_cast<double>(here.rays.size())) / mean;
    compare(findings, Convention::camera_density, here.box / mean, here.box,
            0.02 + 2.0 * rounding + flatness + 4.0 * noise);

    const double t = distance * (0.2 + 2.0 * static_cast<double>(share));
    for (std::size_t i = 0; i < here.rays.size(); ++i) {
      const V origin(here.rays[i].origin.position);
      const auto [u_lens, v_lens] = uniforms<T, 2>(source);
      const auto seen = camera.project(Vec3<T>(origin + t * V(here.rays[i].direction)), {u_lens, v_lens});
      if (!seen || glm::length(V(seen->origin.position) - origin) > 1e-3 * t) continue;
      const Vec2<double> from_p = here.offset(here.places[i]), step(pixel - seen->pixel), from_q = from_p + step;
      shift_x.add(step.x);
      shift_y.add(step.y);
      to_p.add(glm::dot(from_p, from_p));
      to_q.add(glm::dot(from_q, from_q));
      farther.add(glm::dot(from_p + from_q, step));
    }
  }
  if (farther.count() < 2) return;
  const auto is_zero = [](const Moments<double>& m) {
    return z_test(m.mean(), std::sqrt(m.variance() / static_cast<double>(m.count())), 0.0).passes(level);
  };
  findings.judge(Convention::camera_filter, is_zero(shift_x) && is_zero(shift_y) && is_zero(farther), to_q.mean(),
                 to_p.mean());
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
  if (radius > 0.5) detail::check_wide_filter(camera, distance, source, findings);
  return findings;
}

}  // namespace gmis
