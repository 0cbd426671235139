#pragma once

#include "gmis/transport/output/path_output.hpp"
#include "gmis/transport/walk/context.hpp"

namespace gmis {

/// The camera vertex takes the light of all light vertices within the merging radius for its own: density estimation
/// with a constant kernel, biased by what the light varies over the disk.
struct Merge {
  template <class Context, class Vertex, class Output>
  static void at_camera_vertex(const Context& context, const Vertex& vertex, Output& output) {
    using S = typename Vertex::S;
    using T = typename Vertex::T;
    ++output.counters().merge_queries;
    const auto& point = vertex.hit.point;
    context.grid.query(point.position, [&](std::uint32_t index) {
      const auto& light = context.cache[index];
      if (light.depth + vertex.depth > context.max_depth) return;
      const auto [path_class, is_kept] = context.filter.join(
          [&] { return light.path; }, [&] { return context.filter.after_scattering(vertex.path, vertex.hit.bsdf); });
      if (!is_kept) return;
      const auto bsdf = vertex.hit.bsdf.evaluate(vertex.to_prev, light.to_prev, TransportMode::radiance);
      if (is_black(bsdf.value)) return;
      // Photons lie on the surface as the geometric normal sees it; f wants irradiance under the shading normal.
      T correction = context.merge_normalization;
      if (point.shading_normal != point.geometric_normal) {
        const T geometric = std::abs(glm::dot(point.geometric_normal, light.to_prev));
        correction *= geometric > T(0) ? std::abs(glm::dot(point.shading_normal, light.to_prev)) / geometric : T(0);
      }
      const S value = vertex.throughput * bsdf.value * light.throughput * correction;
      const auto weight =
          context.recursion.merge(light.weights, vertex.children.forward * bsdf.pdf.forward.value, vertex.weights,
                                  vertex.is_next_to_camera(), vertex.children.reverse * bsdf.pdf.reverse.value);
      ++output.counters().merges;
      if constexpr (observes_paths<Output>) output.on_light_vertex(light);
      output.add({Technique::merge, static_cast<std::int16_t>(light.depth + 1),
                  static_cast<std::int16_t>(vertex.depth + 1), path_class},
                 value, weight);
    });
  }
};

}  // namespace gmis
