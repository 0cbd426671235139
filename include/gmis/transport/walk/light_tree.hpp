#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/output/path_output.hpp"
#include "gmis/transport/techniques/splat.hpp"
#include "gmis/transport/walk/context.hpp"
#include "gmis/transport/walk/first_hit.hpp"

namespace gmis {

/// Traces the tree of light subpaths that starts at one emission, breadth first. When the counts of the context ask for
/// it, non-specular vertices are stored and connected with the camera, in the order in which they are made. The split
/// policy decides how many children a vertex has; without splitting, the tree is one path.
template <class Context, class Output>
class LightTree {
 public:
  using Sc = typename Context::SceneType;
  using Vertex = LightVertex<Sc, typename Context::Recursion>;
  using S = typename Vertex::S;
  using T = typename Vertex::T;
  using Split = typename Context::Split;
  using Chunk = typename LightVertexCache<typename Context::StoredVertex>::Chunk;

  LightTree(const Context& context, Output& output) : context_(context), output_(output) {}

  /// Traces one tree. `stored` receives the vertices for connections and merging; null keeps none. When the policy
  /// splits light trees, `expanded(bsdf, drawn)` is called after the children of each vertex are drawn.
  template <UniformSource Source, class Expanded>
  void trace(Source source, Chunk* stored, Expanded&& expanded) {
    if (context_.max_depth < 2) return;  // only camera subpaths make light that is seen directly
    ++output_.counters().light_subpaths;
    source.at_vertex(0);
    if constexpr (GuidableLight<typename Sc::Light>)
      if (context_.guide != nullptr) [[unlikely]] {
        trace_guided(source, stored, expanded);
        return;
      }
    if constexpr (Split::splits_light)
      trace_tree<false>(source, stored, expanded);
    else
      trace_path(source, stored);
  }
  template <UniformSource Source>
  void trace(Source source, Chunk* stored) {
    trace(source, stored, [](const auto&, int) {});
  }

 private:
  /// One flat function: an iteration of photon mapping takes 6 % fewer instructions than with calls, one of vertex
  /// connection and merging 2 %. A tree would take a minute to compile that way.
  template <UniformSource Source>
  [[gnu::flatten]] void trace_path(Source& source, Chunk* stored) {
    follow_path<false>(source, stored);
  }
  /// The same with a guide of emission. It is compiled separately, so that runs without one do no work for it.
  template <UniformSource Source, class Expanded>
  [[gnu::noinline]] void trace_guided(Source& source, Chunk* stored, Expanded&& expanded) {
    if constexpr (Split::splits_light)
      trace_tree<true>(source, stored, expanded);
    else
      follow_path<true>(source, stored);
  }
  template <bool is_guided, UniformSource Source>
  void follow_path(Source& source, Chunk* stored) {
    std::optional<Vertex> first = emit<is_guided>(source);
    if (!first) return;
    Vertex& vertex = *first;
    std::uint32_t number = 0;  // number of the vertex in its path; it keys the vertex's random numbers
    for (;;) {
      source.at_vertex(++number);
      use(vertex, source, stored);
      if (!goes_on(vertex)) return;
      const auto step = scatter(scattering_at(vertex), source);
      if (!step) return;
      if (!arrive(vertex, *step)) return;
    }
  }

  template <bool is_guided, UniformSource Source, class Expanded>
  void trace_tree(Source& source, Chunk* stored, Expanded&& expanded) {
    const std::optional<Vertex> first = emit<is_guided>(source);
    std::uint32_t number = 0;
    int remaining = context_.split.budget();
    queue_.clear();
    if (first) queue_.push_back(*first);
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const Vertex at = queue_[next];  // a copy, because the queue reallocates when it grows
      source.at_vertex(++number);
      use(at, source, stored);
      if (!goes_on(at) || context_.split.stops_at(remaining)) continue;
      const int drawn = context_.split.expand(scattering_at(at), remaining, source, [&](const Step<S>& step) {
        Vertex child = at;
        if (arrive(child, step)) queue_.push_back(child);
      });
      expanded(at.bsdf, drawn);
      remaining -= drawn;
    }
  }

  [[nodiscard]] constexpr bool goes_on(const Vertex& at) const noexcept { return at.depth + 1 < context_.max_depth; }

  template <UniformSource Source>
  void use(const Vertex& vertex, Source& source, Chunk* stored) {
    if constexpr (observes_paths<Output>) output_.on_use(vertex);
    if (vertex.bsdf.is_purely_delta() || survival_probability(vertex.bsdf) == T(0)) return;
    if (stored != nullptr && (context_.has.connect || vertex.is_photon) &&
        context_.filter.keeps_light(context_.filter.after_scattering(vertex.path, vertex.bsdf)))
      stored->add(vertex);
    if (context_.has.splat) Splat::at_light_vertex(context_, vertex, source, output_);
  }

  [[nodiscard]] constexpr ScatteringVertex<typename Sc::Bsdf> scattering_at(const Vertex& at) const noexcept {
    const T survival = survival_probability(at.bsdf);
    return {at.bsdf,
            at.point,
            at.to_prev,
            TransportMode::importance,
            survival,
            at.children,
            {at.children.forward, context_.camera_delta_children(survival, false)}};
  }

  /// Draws x_0 and x_1. Returns x_1, or nothing when the ray leaves the scene or a density is unusable.
  template <bool is_guided, UniformSource Source>
  [[nodiscard]] std::optional<Vertex> emit(Source& source) {
    const auto [u_x, u_y, v_x, v_y] = uniforms<T, 4>(source);
    [[maybe_unused]] const GuidedLight<T, typename Sc::Light>* guided = nullptr;
    const auto choice = [&](T u) {
      if constexpr (is_guided)
        return context_.guide->sample_light(context_.scene, u, guided);
      else
        return context_.scene.sample_light(u);
    }(uniform<T>(source));
    const Vec2<T> uv_origin{u_x, u_y}, uv_direction{v_x, v_y};
    if (choice.light == nullptr) return std::nullopt;
    auto emission = [&] {
      if constexpr (is_guided)
        return context_.guide->sample(*choice.light, guided, uv_origin, uv_direction);
      else
        return choice.light->sample_emission(uv_origin, uv_direction);
    }();
    if (!emission) return std::nullopt;

    if constexpr (observes_paths<Output>) output_.on_start(emission->origin, emission->weight);
    ++output_.counters().rays;
    const auto hit = first_hit(context_.scene, emission->origin, emission->direction);
    if (!hit) return std::nullopt;
    if (absorbs(context_.scene) && !choice.light->is_infinite()) [[unlikely]]
      attenuate(context_.scene, emission->origin, emission->direction, hit->point.position, emission->weight);
    const Vec3<T> offset = hit->point.position - emission->origin.position;
    const T distance_squared = glm::dot(offset, offset);
    const bool is_infinite = choice.light->is_infinite();
    const T cos_here = std::abs(glm::dot(hit->point.geometric_normal, emission->direction));
    // a_1: from the measure of `first` (`EmissionDensity`) to area at x_1
    T first = emission->density.first;
    if constexpr (is_guided)
      first *= context_.guide->ratio(*choice.light, choice.selection_probability, first, emission->origin,
                                     emission->direction, hit->point.position);
    const T density = first * (is_infinite ? cos_here : cos_here / distance_squared);
    if (!is_usable(density) || !is_usable(emission->density.origin)) return std::nullopt;

    if constexpr (is_guided) emission->weight = emission->weight * (emission->density.first / first);

    // g_0: b_0 = reverse · g_0; 0 for a delta light, which no ray can hit
    T to_origin = T(0);
    if (!choice.light->is_delta())
      to_origin = is_infinite ? T(1)
                              : solid_angle_per_area(glm::dot(emission->origin.geometric_normal, emission->direction),
                                                     distance_squared);
    // a_0 and e_0, each with its own probability of choosing the light; that of a next event is known only here, where its
    // receiver x_1 is  [Georgiev TR 31–33]
    const T next_event = next_event_probability(context_.scene, choice, hit->point) *
                         choice.light->next_event_density(emission->origin, emission->direction, hit->point);
    const auto weights = context_.recursion.first_light_vertex(choice.selection_probability * emission->density.origin,
                                                               next_event, density, to_origin);
    const Vertex vertex{hit->point,
                        hit->bsdf,
                        -emission->direction,
                        emission->weight * (T(1) / choice.selection_probability),
                        weights,
                        context_.children_of_light_vertex(hit->bsdf),
                        1,
                        context_.lights_make_photons(),
                        {}};
    if constexpr (observes_paths<Output>)
      output_.on_vertex(Step<S>{emission->direction, emission->weight, first, T(0), false}, density, vertex,
                        vertex.point);
    return vertex;
  }

  /// Traces one step from `vertex` and writes the next vertex in its place. Returns false when the ray leaves the scene,
  /// the path class is not wanted or the density is unusable.
  [[nodiscard]] bool arrive(Vertex& vertex, const Step<S>& step) {
    const Vertex& from = vertex;
    const HalfPath path = context_.filter.after_event(from.path, from.bsdf, step.is_delta);
    if (!context_.filter.keeps_light(path)) return false;
    ++output_.counters().rays;
    const auto hit = context_.scene.intersect(leave(from.point, step.to_next));
    if (!hit) return false;
    if (absorbs(context_.scene)) [[unlikely]]
      attenuate(context_.scene, from.point, step.to_next, hit->point.position, vertex.throughput);
    const Vec3<T> offset = hit->point.position - from.point.position;
    const T distance_squared = glm::dot(offset, offset);
    // a_{i+1} = c ψ(x_i → x_{i+1}) |cos θ_{i+1}| / d², c being part of `forward`
    const T density =
        step.forward * solid_angle_per_area(glm::dot(hit->point.geometric_normal, step.to_next), distance_squared);
    if (!is_usable(density)) return false;
    // g_i, for the reverse density at x_{i+1}  [Georgiev TR 34–36]
    const T to_area_back = solid_angle_per_area(glm::dot(from.point.geometric_normal, step.to_next), distance_squared);
    vertex.weights = context_.recursion.extend_light(from.weights, from.is_photon, step.is_delta, step.reverse,
                                                     to_area_back, density);
    vertex.is_photon = context_.makes_photons(from.bsdf);
    // From here on `from` is the next vertex.
    vertex.point = hit->point;
    vertex.bsdf = hit->bsdf;
    vertex.to_prev = -step.to_next;
    vertex.throughput = vertex.throughput * step.weight;
    vertex.children = context_.children_of_light_vertex(hit->bsdf);
    ++vertex.depth;
    vertex.path = path;
    if constexpr (observes_paths<Output>) output_.on_vertex(step, density, vertex, vertex.point);
    return true;
  }

  /// False, and counts a rejection, for a density that is zero or not finite.
  [[nodiscard]] bool is_usable(T density) {
    if (is_usable_density(density)) [[likely]]
      return true;
    output_.reject(RejectionCause::zero_pdf, {});
    return false;
  }

  const Context& context_;
  Output& output_;
  std::vector<Vertex> queue_;  // reused for every tree, so that it stops allocating
};

}  // namespace gmis
