#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <vector>

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

/// The mean of numbers that should be 0 on the mean, in standard errors.
struct Deviation {
  double count = 0.0, sum = 0.0, squares = 0.0;

  void add(double value) noexcept {
    count += 1.0;
    sum += value;
    squares += value * value;
  }
  [[nodiscard]] bool is_large() const noexcept {
    constexpr double standard_errors = 6.0;
    return std::abs(sum) > standard_errors * std::sqrt(squares) + 1e-9 * count;
  }
};

/// Checks a camera whose filter h is wider than a pixel. The points x of the film that the rays of
/// a pixel p pass have the density h(x − c_p), and H(x) is the sum of this over all pixels.
///
/// Both members state the density of a box times H. The box is known from rays of the pixels
/// around, and ∫ h/H = 1 for each pixel, so the mean of the quotient of both densities over rays of
/// a pixel is 1.
///
/// The pixel q that `project` returns for x has the probability h(x − c_q) / H(x), and so has p
/// once x is known. They are exchangeable: q − p and |x − c_q|² − |x − c_p|² are 0 on the mean.
template <Camera C, UniformSource Source>
void check_wide_filter(const C& camera, double distance, Source& source, Findings& findings) {
  using T = ScalarOf<typename C::Spectrum>;
  using V = Vec3<double>;
  constexpr int pixels = 64, side = 8;
  const int margin = static_cast<int>(std::ceil(2.0 * filter_radius_of(camera)));
  const glm::ivec2 inner = glm::ivec2(camera.resolution()) - 2 * margin;
  if (inner.x < 1 || inner.y < 1) return;
  const auto number = [&source] { return uniform<T>(source); };
  Deviation shift_x, shift_y, farther;
  double to_p = 0.0, to_q = 0.0;
  for (int k = 0; k < pixels; ++k) {
    const glm::ivec2 pixel = margin + glm::ivec2(Vec2<double>(number(), number()) * 0.999999 * Vec2<double>(inner));
    const Vec2<T> lens{number(), number()};
    std::vector<CameraSample<typename C::Spectrum>> rays;
    std::vector<V> places;
    V middle(0), column(0), row(0);
    Deviation quotient;  // of the density of a box and the one stated, less 1
    double box = 0.0;
    for (int i = 0; i < side * side; ++i) {
      const Vec2<T> uv{(static_cast<T>(i % side) + number()) / T(side),
                       (static_cast<T>(i / side) + number()) / T(side)};
      const auto place = [&](int x, int y) {
        const auto ray = camera.sample_ray(pixel + glm::ivec2(x, y), uv, lens);
        if (!ray) return V(std::numeric_limits<double>::quiet_NaN());
        return camera.has_parallel_rays() ? V(ray->origin.position) : V(ray->direction);
      };
      const auto ray = camera.sample_ray(pixel, uv, lens);
      const V here = place(0, 0), along_x = 0.5 * (place(1, 0) - place(-1, 0)),
              along_y = 0.5 * (place(0, 1) - place(0, -1));
      const double area = glm::length(glm::cross(along_x, along_y));
      if (!ray || !std::isfinite(area) || !(ray->density > T(0))) break;
      rays.push_back(*ray);
      places.push_back(here);
      middle += here;
      column += along_x;
      row += along_y;
      box += 1.0 / area;
      quotient.add(1.0 / (area * static_cast<double>(ray->density)) - 1.0);
    }
    const double count = quotient.count, mean = quotient.sum / std::max(1.0, count);
    if (count < side * side) continue;
    middle /= count, column /= count, row /= count, box /= count;
    const double magnitude = camera.has_parallel_rays() ? glm::length(middle) : 1.0, width = 1.0 / std::sqrt(box);
    const double rounding = 8.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * magnitude / width;
    if (rounding > 0.05) continue;
    findings.look_at(0, {V(rays[0].origin.position), V(0), V(rays[0].direction)});
    // A pixel is not flat: differences over two of them are off by a part of their squared angle.
    const double flatness = camera.has_parallel_rays() ? 0.0 : width * width;
    const double error = std::sqrt(std::max(0.0, quotient.squares / count - mean * mean) / count) / (1.0 + mean);
    compare(findings, Convention::camera_density, box / (1.0 + mean), box,
            0.02 + 2.0 * rounding + flatness + 4.0 * error);

    const double xx = glm::dot(column, column), xy = glm::dot(column, row), yy = glm::dot(row, row);
    const double t = distance * (0.2 + 2.0 * static_cast<double>(number()));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const V origin(rays[i].origin.position), offset = places[i] - middle;
      const auto seen = camera.project(Vec3<T>(origin + t * V(rays[i].direction)), {number(), number()});
      if (!seen || glm::length(V(seen->origin.position) - origin) > 1e-3 * t) continue;
      const Vec2<double> d(pixel - seen->pixel);
      const double x = glm::dot(offset, column), y = glm::dot(offset, row);
      const Vec2<double> a = Vec2<double>(yy * x - xy * y, xx * y - xy * x) / (xx * yy - xy * xy);
      shift_x.add(d.x);
      shift_y.add(d.y);
      farther.add(glm::dot(2.0 * a + d, d));
      to_p += glm::dot(a, a);
      to_q += glm::dot(a + d, a + d);
    }
  }
  const double count = std::max(1.0, farther.count);
  findings.judge(Convention::camera_filter, !(shift_x.is_large() || shift_y.is_large() || farther.is_large()),
                 to_q / count, to_p / count);
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
