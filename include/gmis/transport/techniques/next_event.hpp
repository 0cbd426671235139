#pragma once

#include "gmis/core/light_choice.hpp"
#include "gmis/core/light_groups.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Technique s = 1, next-event estimation: samples a point on a light for the camera vertex (a
/// direction, for an infinite light) and connects the two.
struct NextEvent {
  /// Takes one sample for a non-specular camera vertex and adds its contribution to `output`.
  /// Always draws three random numbers. A sample that is visible but whose density is zero or not
  /// finite is rejected as `RejectionCause::zero_pdf`.
  template <class Context, class Vertex, class Output>
  static void at_camera_vertex(const Context& context, const Vertex& vertex, UniformSource auto& source,
                               Output& output) {
    using S = typename Vertex::S;
    using T = typename Vertex::T;
    const auto [u_light, u, v] = uniforms<T, 3>(source);
    const auto [path_class, is_kept] = context.filter.join(
        [] { return HalfPath(); }, [&] { return context.filter.after_scattering(vertex.path, vertex.hit.bsdf); });
    if (!is_kept) return;
    const auto& point = vertex.hit.point;
    const auto choice = sample_light_for(context.scene, point, u_light, context.chooses_for_receiver);
    if (choice.light == nullptr) return;
    const auto sample = choice.light->sample_next_event(point, Vec2<T>{u, v});
    if (!sample) return;

    const auto bsdf = evaluate_bsdf<Context::has_light_side>(vertex.hit.bsdf, vertex.to_prev, sample->to_light,
                                                             TransportMode::radiance);
    if (is_black(bsdf.value)) return;
    const T cosine = scattering_cosine(point, vertex.to_prev, sample->to_light, TransportMode::radiance);
    S value = vertex.throughput * bsdf.value * sample->weight * (cosine / choice.selection_probability);
    if (is_black(value)) return;

    const bool is_infinite = choice.light->is_infinite();
    ++output.counters().shadow_rays;
    if (!context.scene.visible(is_infinite ? leave(point, sample->to_light)
                                           : segment(point, sample->origin, sample->to_light)))
      return;

    const TechniqueId id{Technique::next_event, 1, static_cast<std::int16_t>(vertex.depth + 1), path_class,
                         light_group_of(context.scene, *choice.light)};
    if (!is_usable_density(sample->next_event_density)) [[unlikely]] {
      output.reject(RejectionCause::zero_pdf, id);
      return;
    }
    // `to_vertex_area` is g_1: a_1 = first · g_1, with g_1 = |cos θ_1| / d² (|cos θ_1| alone for an
    // infinite light). `hit` is b_0 = c ψ(x_1 → x_0) g_0, with g_0 = |cos θ_0| / d² (1 for an
    // infinite light, 0 for a delta light).
    T to_vertex_area = std::abs(glm::dot(point.geometric_normal, sample->to_light));
    T hit(0);
    if (is_infinite) {
      if (!choice.light->is_delta()) hit = vertex.children.forward * bsdf.pdf.forward.value;
    } else {
      const Vec3<T> offset = point.position - sample->origin.position;
      const T distance_squared = glm::dot(offset, offset);
      to_vertex_area /= distance_squared;
      if (!choice.light->is_delta())
        hit = vertex.children.forward * bsdf.pdf.forward.value *
              (std::abs(glm::dot(sample->origin.geometric_normal, sample->to_light)) / distance_squared);
    }
    const T emission_choice = emission_probability(context.scene, choice);
    const T first = guided_first(context, *choice.light, emission_choice, sample->density.first, sample->origin,
                                 -sample->to_light, point.position);
    // a_0 and e_0, each with its own probability of choosing the light, b_0, a_1, and the density
    // back to x_2 [Georgiev TR 37, 44, 45].
    const auto weight =
        context.recursion.next_event({.origin = emission_choice * sample->density.origin,
                                      .next_event = choice.selection_probability * sample->next_event_density,
                                      .first = first},
                                     hit, vertex.weights,
                                     {.is_next_to_camera = vertex.is_next_to_camera(),
                                      .reverse = vertex.children.reverse * bsdf.pdf.reverse.value,
                                      .density = first * to_vertex_area});
    output.on_light_point(sample->origin);
    if (absorbs(context.scene) && !is_infinite) [[unlikely]]
      attenuate(context.scene, point, sample->to_light, sample->origin, value);
    output.add(id, value, weight);
  }
};

}  // namespace gmis
