#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gmis/core/random.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Technique s, t ≥ 2: connects a camera vertex with vertices of light trees. It takes either m
/// vertices drawn uniformly from the cache of all trees, so that the work does not grow with the
/// trees, or all vertices of the one tree that the pixel is paired with
/// (`SampleCounts::connects_paired_tree`). Call it for non-specular camera vertices; the cache
/// holds non-specular vertices only.
struct Connect {
  /// Makes the connections of one camera vertex and adds their contributions to `output`. Pairs
  /// that would exceed `max_depth`, have f = 0 at either end or do not see each other add nothing.
  template <class Context, class Vertex, class Output>
  static void at_camera_vertex(const Context& context, const Vertex& vertex, std::size_t pixel,
                               UniformSource auto& source, Output& output) {
    using T = typename Vertex::T;
    using StoredVertex = typename Context::StoredVertex;
    const auto& cache = context.light.cache;
    const bool takes_tree = context.counts.connects_paired_tree;
    const auto tree = takes_tree ? cache.tree(context.tree_of_pixel(pixel)) : std::span<const StoredVertex>();
    const auto drawn = cache.size() > 0 ? static_cast<std::size_t>(context.counts.connections) : 0;
    const T scale = takes_tree ? T(1) : context.light.connection_scale;
    // One loop, so that `connect`, which is inlined here, is compiled once.
    const StoredVertex* next_of_tree = tree.data();
    for (std::size_t left = takes_tree ? tree.size() : drawn; left > 0; --left) {
      const StoredVertex& light = next_of_tree != nullptr
                                      ? *next_of_tree++
                                      : cache[uniform_index(source, static_cast<std::uint32_t>(cache.size()))];
      if (light.depth() + vertex.depth < context.max_depth) connect(context, vertex, light, scale, output);
    }
  }

 private:
  /// True when the two directions, of any length, are on different sides of the surface.
  template <std::floating_point T>
  [[nodiscard]] static constexpr bool is_behind(const SurfacePoint<T>& point, const Vec3<T>& a,
                                                const Vec3<T>& b) noexcept {
    return (glm::dot(point.shading_normal, a) > T(0)) != (glm::dot(point.shading_normal, b) > T(0));
  }

  /// `scale`: factor on the throughput of the light vertex, V / (m n_L) for a vertex drawn from the
  /// cache, else 1.
  template <class Context, class Vertex, class Output>
  static void connect(const Context& context, const Vertex& vertex, const typename Context::StoredVertex& light,
                      typename Vertex::T scale, Output& output) {
    using S = typename Vertex::S;
    using T = typename Vertex::T;
    const auto& point = vertex.hit.point;
    const auto& bsdf_of_light = light.bsdf();
    const auto [path_class, is_kept] =
        context.filter.join([&] { return context.filter.after_scattering(light.path(), bsdf_of_light); },
                            [&] { return context.filter.after_scattering(vertex.path, vertex.hit.bsdf); });
    if (!is_kept) return;
    ++output.counters().connections;

    // Before a root and two BSDFs: hemispheres.
    const Vec3<T> offset = light.point.position - point.position;
    if (is_behind(point, vertex.to_prev, offset) && reflects_only(vertex.hit.bsdf)) return;
    if (is_behind(light.point, light.to_prev, -offset) && reflects_only(bsdf_of_light)) return;
    const auto link = Link<T>::along(offset);
    if (!(link.distance_squared > T(0))) return;
    const auto camera_bsdf = vertex.hit.bsdf.evaluate(vertex.to_prev, link.direction, TransportMode::radiance);
    if (is_black(camera_bsdf.value)) return;
    const auto light_bsdf = bsdf_of_light.evaluate(light.to_prev, -link.direction, TransportMode::importance);
    if (is_black(light_bsdf.value)) return;

    // G = |cos| |cos| / d², with the cosines that belong to f at either end
    const T geometry = scattering_cosine(point, vertex.to_prev, link.direction, TransportMode::radiance) *
                       scattering_cosine(light.point, light.to_prev, -link.direction, TransportMode::importance) /
                       link.distance_squared * scale;
    S value = vertex.throughput * camera_bsdf.value * light_bsdf.value * light.throughput * geometry;
    if (is_black(value)) return;

    ++output.counters().shadow_rays;
    ++output.counters().connection_rays;
    if (!context.scene.visible(segment(point, light.point, link.direction))) return;
    if (absorbs(context.scene)) [[unlikely]]
      attenuate(context.scene, point, link.direction, light.point, value);

    // With x_{s−1} the light vertex and x_s the camera vertex
    // [Georgiev TR 37, 40, 41; docs/weights.md]:
    //   b_{s−1} = c ψ(x_s → x_{s−1}) g_{s−1},   a_s = c ψ(x_{s−1} → x_s) g_s,
    //   reverse densities per steradian: at x_{s−1} back to x_{s−2}, at x_s back to x_{s+1}.
    const NominalChildren<T> children = context.children_of_light_vertex(bsdf_of_light);
    const LightEnd<T> light_end{
        .is_photon = light.is_photon(),
        .makes_photons = context.makes_photons(bsdf_of_light),
        .reverse = children.reverse * light_bsdf.pdf.reverse.value,
        .density = vertex.children.forward * camera_bsdf.pdf.forward.value * link.to_area(light.point)};
    const CameraEnd<T> camera_end{.is_next_to_camera = vertex.is_next_to_camera(),
                                  .reverse = vertex.children.reverse * camera_bsdf.pdf.reverse.value,
                                  .density = children.forward * light_bsdf.pdf.forward.value * link.to_area(point)};
    const auto weight = context.recursion.connect(light.weights(), light_end, vertex.weights, camera_end);
    output.on_light_vertex(light);
    output.add({Technique::connect, static_cast<std::int16_t>(light.depth() + 1),
                static_cast<std::int16_t>(vertex.depth + 1), path_class, light.light_group()},
               value, weight);
  }
};

}  // namespace gmis
