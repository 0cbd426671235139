#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/transport/state/first_hit.hpp"
#include "gmis/transport/state/scatter.hpp"

namespace gmis {

/// The median width of a pixel, in scene units, at the first non-specular vertices of camera
/// subpaths. The width is the distance travelled times the square root of the pixel's solid angle;
/// for a camera with parallel rays it is the square root of the pixel's area. The median depends on
/// the visible part of the scene alone, not on the crop nor on hidden objects. When no camera
/// subpath finds a non-specular surface, the result is the width at distance 1 (1 when the camera
/// makes no ray at all).
template <Scene Sc>
GMIS_RARE [[nodiscard]] inline double median_pixel_width(const Sc& scene) {
  using T = ScalarOf<typename Sc::Spectrum>;
  constexpr int most_across = 48, deepest = 16;
  constexpr std::uint32_t stream = 3;  // the others: `Engine::Stream`
  const auto& camera = scene.camera();
  const glm::ivec2 size = camera.resolution();
  const int step = std::max(1, std::max(size.x, size.y) / most_across);
  std::vector<double> widths;
  double fallback = 1.0;
  const glm::ivec2 first = glm::min(glm::ivec2(step / 2), size - 1);  // a row of pixels is lower than a step
  for (int y = first.y; y < size.y; y += step)
    for (int x = first.x; x < size.x; x += step) {
      Philox source(0, 0, static_cast<std::uint32_t>(y * size.x + x), stream);
      const auto sample = camera.sample_ray({x, y}, {T(0.5), T(0.5)}, {T(0.5), T(0.5)});
      if (!sample || !(sample->density > T(0))) continue;
      const double at_unit_distance = 1.0 / std::sqrt(static_cast<double>(sample->density));
      fallback = at_unit_distance;
      SurfacePoint<T> from = sample->origin;
      Vec3<T> direction = sample->direction;
      double distance = 0.0;
      for (int depth = 0; depth < deepest; ++depth) {
        const auto hit = depth == 0 ? first_hit(scene, from, direction) : scene.intersect(leave(from, direction));
        if (!hit) break;
        distance += static_cast<double>(glm::length(hit->point.position - from.position));
        if (!hit->bsdf.is_purely_delta()) {
          widths.push_back(camera.has_parallel_rays() ? at_unit_distance : distance * at_unit_distance);
          break;
        }
        const T u = uniform<T>(source);
        const auto next = hit->bsdf.sample(-direction, u, {T(0.5), T(0.5)}, TransportMode::radiance);
        if (!next) break;
        from = hit->point;
        direction = next->to_next;
      }
    }
  if (widths.empty()) return fallback;
  double* const middle = widths.data() + widths.size() / 2;
  std::nth_element(widths.data(), middle, widths.data() + widths.size());
  return *middle;
}

/// Default merging radius of the first iteration in scene units: 0.4 pixel widths. It replaces an
/// unset `RenderSettings::radius`.
template <Scene Sc>
[[nodiscard]] inline double default_radius(const Sc& scene) {
  constexpr double pixel_widths = 0.4;
  return pixel_widths * median_pixel_width(scene);
}

}  // namespace gmis
