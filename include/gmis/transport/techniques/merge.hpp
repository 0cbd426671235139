#pragma once

#include <algorithm>
#include <cmath>

#include "gmis/core/math.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Technique merge: estimates the radiance that a camera vertex reflects from all light vertices
/// (photons) within the merging radius. It is a density estimate with the constant kernel 1/(n_L π
/// r²), times a gain near 1 (`AnyEngine::scale_merging`); it is biased when the light or the
/// surface varies over the disk. Photons on a surface of another orientation are left out: they
/// measure another irradiance (`least_normal_cosine`). So are photons on a surface beside that of
/// the camera vertex (`least_height`).
struct Merge {
  /// Least |cos| between the geometric normals of a camera vertex and of a photon that it gathers.
  /// Around an edge a disk would gather the light of the bright side on the dark one; no shadow ray
  /// is traced between the two. Without these photons, a disk loses the light beyond the edge, as
  /// it does at the border of a surface, in proportion to the radius. Weights are those of the
  /// whole disk. The sign does not count: meshes may be wound either way, and a BSDF is black for
  /// light from behind.
  static constexpr double least_normal_cosine = 0.8;

  /// Height above the surface of the camera vertex, in merging radii, from which a photon counts as
  /// one of another surface: of a step, or of a bar in front of a wall. The light of such a surface
  /// does not fade with the radius until the radius is as small as the step, so half the radius
  /// would show no bias. Waves and rounding also make lower heights.
  static constexpr double least_height = 0.1;

  /// True when two points with these geometric normals cannot lie on one surface that bends one way
  /// between them. `chord` leads from one to the other. Between them the direction of such a
  /// surface turns by the angle θ of the normals, and the chord is a mean of these directions: it
  /// rises above the plane normal to the mean of the normals by at most the angle θ/2. Normals may
  /// point to either side. Heights above that plane with a square up to `height_squared` count as
  /// 0.
  template <class T>
  [[nodiscard]] static bool is_beside(const Vec3<T>& chord, const Vec3<T>& normal, const Vec3<T>& other_normal,
                                      T height_squared) noexcept {
    const T cosine = glm::dot(normal, other_normal), size = std::abs(cosine);
    const T height = glm::dot(chord, cosine < T(0) ? normal - other_normal : normal + other_normal);
    // |n + n'|² is 2 (1 + cos θ), and sin²(θ/2) is (1 − cos θ)/2.
    const T most = std::max(glm::dot(chord, chord) * (T(1) - size) / T(2), height_squared);
    return square(height) > T(2) * (T(1) + size) * most;
  }

  /// Merges one non-specular camera vertex with the stored light vertices within the merging radius
  /// and adds the contributions to `output`. Pairs that would exceed `max_depth` or have f = 0 add
  /// nothing.
  template <class Context, class Vertex, class Output>
  static void at_camera_vertex(const Context& context, const Vertex& vertex, Output& output) {
    using S = typename Vertex::S;
    using T = typename Vertex::T;
    ++output.counters().merge_queries;
    const auto& point = vertex.hit.point;
    const T height_squared = static_cast<T>(square(least_height)) / context.photons.inverse_radius_squared;
    context.photons.grid.query(point.position, [&](std::uint32_t index) {
      const auto& light = context.light.cache[index];
      if (light.depth() + vertex.depth > context.max_depth) return;
      const T normal_cosine = std::abs(glm::dot(point.geometric_normal, light.point.geometric_normal));
      if (normal_cosine < static_cast<T>(least_normal_cosine)) return;
      if (is_beside(light.point.position - point.position, point.geometric_normal, light.point.geometric_normal,
                    height_squared))
        return;
      const auto [path_class, is_kept] = context.filter.join(
          [&] { return light.path(); }, [&] { return context.filter.after_scattering(vertex.path, vertex.hit.bsdf); });
      if (!is_kept) return;
      const auto bsdf = vertex.hit.bsdf.evaluate(vertex.to_prev, light.to_prev, TransportMode::radiance);
      if (is_black(bsdf.value)) return;
      // The photon density is irradiance with the geometric normal, but f expects irradiance with
      // the shading normal: kernel · |n_s · ω| / |n_g · ω|, the kernel being 1/(n_L π r²).
      T correction = context.photons.normalization;
      if (point.shading_normal != point.geometric_normal) {
        const T geometric = std::abs(glm::dot(point.geometric_normal, light.to_prev));
        correction *= geometric > T(0) ? std::abs(glm::dot(point.shading_normal, light.to_prev)) / geometric : T(0);
      }
      const S value = vertex.throughput * bsdf.value * light.throughput * correction;
      // Merged at x_i: the density at x_i per steradian back to x_{i−1}, by the camera subpath, and
      // back to x_{i+1}, by the light subpath [Georgiev TR 37–39; docs/weights.md].
      const auto weight =
          context.recursion.merge(light.weights(), vertex.children.forward * bsdf.pdf.forward.value, vertex.weights,
                                  {.is_next_to_camera = vertex.is_next_to_camera(),
                                   .reverse = vertex.children.reverse * bsdf.pdf.reverse.value,
                                   .density = T(0)});
      ++output.counters().merges;
      output.on_light_vertex(light);
      const Vec3<T> offset = point.position - light.point.position;
      output.on_merge(glm::dot(offset, offset) * context.photons.inverse_radius_squared);
      output.add({Technique::merge, static_cast<std::int16_t>(light.depth() + 1),
                  static_cast<std::int16_t>(vertex.depth + 1), path_class, light.light_group()},
                 value, weight);
    });
  }
};

}  // namespace gmis
