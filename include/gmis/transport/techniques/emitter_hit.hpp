#pragma once

#include "gmis/core/light_choice.hpp"
#include "gmis/core/light_groups.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/path_output.hpp"

namespace gmis {

/// Technique s = 0: a camera subpath meets a light, either a surface that emits or an infinite
/// light.
struct EmitterHit {
  /// Adds the radiance that `vertex.hit.light` emits at `vertex` along `to_prev`. `weights` are the
  /// partial sums there with s(x_0), the local count of merging at a light, in place of the
  /// surface's. `from` is the vertex before `vertex`.
  template <class Context, class Vertex, class Weights, class Point, class Output>
  static void at_camera_vertex(const Context& context, const Vertex& vertex, const Weights& weights, const Point& from,
                               Output& output) {
    add(context, *vertex.hit.light, vertex.hit.point, vertex.to_prev, vertex.throughput, weights, vertex.depth,
        vertex.path, from, output);
  }

  /// Adds the radiance of all infinite lights that are no delta lights, for a ray that left the
  /// scene along −`emission_direction`. `weights` and `depth` belong to the vertex at infinity.
  template <class Context, class Direction, class S, class Weights, class Point, class Output>
  static void at_escape(const Context& context, const Direction& emission_direction, const S& throughput,
                        const Weights& weights, int depth, HalfPath path, const Point& from, Output& output) {
    for (const auto* light : context.scene.infinite_lights())
      if (!light->is_delta())
        add(context, *light, Point{}, emission_direction, throughput, weights, depth, path, from, output);
  }

 private:
  template <class Context, class L, class Point, class Direction, class S, class Weights, class Output>
  static void add(const Context& context, const L& light, const Point& origin, const Direction& direction,
                  const S& throughput, const Weights& weights, int depth, HalfPath path, const Point& from,
                  Output& output) {
    const auto [path_class, is_kept] = context.filter.join([] { return HalfPath(); }, [&] { return path; });
    if (!is_kept) return;
    const auto emitted = light.emitted(origin, direction);
    if (is_black(emitted.radiance)) return;
    const TechniqueId id{Technique::emitter_hit, 0, static_cast<std::int16_t>(depth + 1), path_class,
                         light_group_of(context.scene, light)};
    if (depth == 1) {  // k = 1: no other technique makes the path, weight 1
      output.add(id, throughput * emitted.radiance, context.recursion.seen_directly());
      return;
    }
    const LightChoice<ScalarOf<S>, L> choice{&light, context.scene.selection_probability(light)};
    const auto first = guided_first(context, light, choice.selection_probability, emitted.density.first, origin,
                                    direction, from.position);
    // a_0 and e_0, each with its own probability of choosing the light, and a_1 in the measure of
    // `EmissionDensity::first` [Georgiev TR 37, 42, 43].
    const auto weight = context.recursion.emitter_hit(
        weights, {.origin = choice.selection_probability * emitted.density.origin,
                  .next_event = next_event_probability(context.scene, choice, from, context.chooses_for_receiver) *
                                light.next_event_density(origin, direction, from),
                  .first = first});
    output.add(id, throughput * emitted.radiance, weight);
  }
};

}  // namespace gmis
