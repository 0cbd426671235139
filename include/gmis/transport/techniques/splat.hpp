#pragma once

#include "gmis/core/random.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Technique t = 1: connects a light vertex with the camera and adds to the pixel that sees it.
struct Splat {
  /// Connects one non-specular light vertex with a point of the lens and adds the contribution to
  /// `output`. A vertex that no pixel of the crop sees, or that the camera cannot see, adds
  /// nothing. Always draws two random numbers, or none for a camera without a lens.
  template <class Context, class Stored, class Output>
  static void at_light_vertex(const Context& context, const Stored& light, UniformSource auto& source, Output& output) {
    using S = typename Stored::S;
    using T = typename Stored::T;
    const auto& camera = context.scene.camera();
    Vec2<T> uv_lens(T(0.5));
    if (reads_lens_numbers(camera)) uv_lens = {uniform<T>(source), uniform<T>(source)};
    const auto [path_class, is_kept] = context.filter.join(
        [&] { return context.filter.after_scattering(light.path, light.bsdf); }, [] { return HalfPath(); });
    if (!is_kept) return;
    ++output.counters().projections;
    const auto seen = camera.project(light.point.position, uv_lens);
    if (!seen) return;
    const std::int64_t pixel = context.frame.pixel_index(seen->pixel);
    if (pixel < 0) return;
    if (!output.takes(static_cast<std::uint32_t>(pixel))) return;

    const auto bsdf = light.bsdf.evaluate(light.to_prev, seen->to_camera, TransportMode::importance);
    if (is_black(bsdf.value)) return;
    const auto link = Link<T>::between(light.point.position, seen->origin.position);
    const T falloff = camera.has_parallel_rays() ? T(1) : T(1) / link.distance_squared;
    // The pixel's value is the mean radiance over its camera rays, so its response to flux is the
    // density of those rays, here per area perpendicular to the ray at the light vertex.
    const T response = seen->density * falloff;
    const T cosine = scattering_cosine(light.point, light.to_prev, seen->to_camera, TransportMode::importance);
    S value =
        light.throughput * bsdf.value * seen->weight * (cosine * response / static_cast<T>(context.light.tree_count));
    if (is_black(value)) return;

    ++output.counters().shadow_rays;
    if (!context.scene.visible(segment(light.point, seen->origin, seen->to_camera))) return;
    if (absorbs(context.scene)) [[unlikely]]
      attenuate(context.scene, light.point, seen->to_camera, seen->origin, value);

    // b_{k−1}: density of the pixel's camera rays per area at the light vertex
    const T camera_density = response * std::abs(glm::dot(light.point.geometric_normal, seen->to_camera));
    // c of the camera subpath at x_{k−1}, which is its first non-specular vertex
    const T camera_children = context.camera_children(T(1));
    // b_{k−2} = c ψ(x_{k−1} → x_{k−2}) g_{k−2}; its first two factors are passed
    // [Georgiev TR 37, 46, 47].
    const auto weight = context.recursion.splat(light.weights, {.is_photon = light.is_photon,
                                                                .makes_photons = false,
                                                                .reverse = camera_children * bsdf.pdf.reverse.value,
                                                                .density = camera_density});
    ++output.counters().splats;
    output.add_splat(static_cast<std::uint32_t>(pixel),
                     {Technique::splat, static_cast<std::int16_t>(light.depth + 1), 1, path_class, light.light_group},
                     value, weight);
  }
};

}  // namespace gmis
