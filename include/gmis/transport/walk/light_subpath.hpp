#pragma once

#include <cmath>
#include <cstddef>
#include <optional>

#include "gmis/core/light_choice.hpp"
#include "gmis/core/light_groups.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/first_hit.hpp"
#include "gmis/transport/state/path_output.hpp"
#include "gmis/transport/state/scatter.hpp"
#include "gmis/transport/techniques/splat.hpp"
#include "gmis/transport/walk/hot_walk.hpp"

namespace gmis {

/// The steps of light subpaths, from which a walk is made: how one starts, what is done at a
/// vertex, how it goes on.
template <class Context, class Output>
class LightSubpath {
 public:
  using Sc = typename Context::SceneType;
  using Vertex = LightVertex<Sc, typename Context::Recursion>;
  using S = typename Vertex::S;
  using T = typename Vertex::T;
  using Chunk = typename LightVertexCache<typename Context::StoredVertex>::Chunk;

 protected:
  LightSubpath(const Context& context, Output& output) : context_(context), output_(output) {}

  [[nodiscard]] constexpr bool goes_on(const Vertex& at) const noexcept { return at.depth + 1 < context_.max_depth; }

  /// Stores a non-specular vertex when the counts of the context ask for it, and connects it with
  /// the camera.
  template <UniformSource Source>
  void use(const Vertex& vertex, Source& source, Chunk* stored) {
    output_.on_use(vertex);
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
            {at.children.forward, camera_survival(survival)}};
  }

  /// Draws x_0 and x_1. Returns x_1, or nothing when the ray leaves the scene or a density is
  /// unusable.
  template <bool is_guided, UniformSource Source>
  [[nodiscard]] std::optional<Vertex> emit(Source& source) {
    [[maybe_unused]] const GuidedLight<T, typename Sc::Light>* guided = nullptr;
    const auto [u_x, u_y, v_x, v_y] = uniforms<T, 4>(source);
    const auto choice = choose_light<is_guided>(uniform<T>(source), guided);
    const Vec2<T> uv_origin{u_x, u_y}, uv_direction{v_x, v_y};
    if (choice.light == nullptr) return std::nullopt;
    auto emission = [&] {
      if constexpr (is_guided)
        return context_.guide->sample(*choice.light, guided, uv_origin, uv_direction);
      else
        return choice.light->sample_emission(uv_origin, uv_direction);
    }();
    if (!emission) return std::nullopt;

    output_.on_start(emission->origin, emission->weight);
    ++output_.counters().rays;
    const auto hit = first_hit(context_.scene, emission->origin, emission->direction);
    if (!hit) return std::nullopt;
    if (absorbs(context_.scene) && !choice.light->is_infinite()) [[unlikely]]
      attenuate(context_.scene, emission->origin, emission->direction, hit->point, emission->weight);
    // a_1: from the measure of `first` (`EmissionDensity`) to area at x_1
    T first = emission->density.first;
    if constexpr (is_guided) {
      first *= context_.guide->ratio(*choice.light, choice.selection_probability, first, emission->origin,
                                     emission->direction, hit->point.position);
      emission->weight = emission->weight * (emission->density.first / first);
    }
    return first_vertex(choice, *emission, *hit, first);
  }

  /// x_1, which `hit` is, made by `emission` with the density `first` of its direction or line;
  /// nothing when a density is unusable.
  template <class Choice, class Emission, class HitPoint>
  [[nodiscard]] std::optional<Vertex> first_vertex(const Choice& choice, const Emission& emission, const HitPoint& hit,
                                                   T first) {
    const Vec3<T> offset = hit.point.position - emission.origin.position;
    const T distance_squared = glm::dot(offset, offset);
    const bool is_infinite = choice.light->is_infinite();
    const T cos_here = std::abs(glm::dot(hit.point.geometric_normal, emission.direction));
    const T density = first * (is_infinite ? cos_here : cos_here / distance_squared);
    if (!is_usable(density) || !is_usable(emission.density.origin)) return std::nullopt;

    // g_0: b_0 = reverse · g_0; 0 for a delta light, which no ray can hit
    T to_origin = T(0);
    if (!choice.light->is_delta())
      to_origin = is_infinite ? T(1)
                              : solid_angle_per_area(glm::dot(emission.origin.geometric_normal, emission.direction),
                                                     distance_squared);
    // a_0 and e_0, each with its own probability of choosing the light; that of a next event is
    // known only here, where its
    // receiver x_1 is  [Georgiev TR 31–33]
    const T next_event = next_event_probability(context_.scene, choice, hit.point, context_.chooses_for_receiver) *
                         choice.light->next_event_density(emission.origin, emission.direction, hit.point);
    const auto weights = context_.recursion.first_light_vertex(
        {.origin = choice.selection_probability * emission.density.origin, .next_event = next_event, .first = density},
        to_origin);
    const Vertex vertex{hit.point,
                        hit.bsdf,
                        -emission.direction,
                        emission.weight * (T(1) / choice.selection_probability),
                        weights,
                        context_.children_of_light_vertex(hit.bsdf),
                        1,
                        context_.lights_make_photons(),
                        light_group_of(context_.scene, *choice.light),
                        {}};
    output_.on_vertex(Step<S>{emission.direction, emission.weight, first, T(0), false}, density, vertex, vertex.point);
    return vertex;
  }

  /// Traces one step from `vertex` and writes the next vertex in its place. Returns false when the
  /// ray leaves the scene, the path class is not wanted or the density is unusable.
  [[nodiscard]] bool arrive(Vertex& vertex, const Step<S>& step) {
    const Vertex& from = vertex;
    const HalfPath path = context_.filter.after_event(from.path, from.bsdf, step.is_delta);
    if (!context_.filter.keeps_light(path)) return false;
    ++output_.counters().rays;
    const auto hit = context_.scene.intersect(leave(from.point, step.to_next));
    if (!hit) return false;
    if (absorbs(context_.scene)) [[unlikely]]
      attenuate(context_.scene, from.point, step.to_next, hit->point, vertex.throughput);
    const Vec3<T> offset = hit->point.position - from.point.position;
    const T distance_squared = glm::dot(offset, offset);
    // a_{i+1} = c ψ(x_i → x_{i+1}) |cos θ_{i+1}| / d², c being part of `forward`
    const T density =
        step.forward * solid_angle_per_area(glm::dot(hit->point.geometric_normal, step.to_next), distance_squared);
    if (!is_usable(density)) return false;
    // g_i, for the reverse density at x_{i+1}  [Georgiev TR 34–36]
    const T to_area_back = solid_angle_per_area(glm::dot(from.point.geometric_normal, step.to_next), distance_squared);
    vertex.weights = context_.recursion.extend_light(from.weights, {.is_photon = from.is_photon,
                                                                    .is_delta = step.is_delta,
                                                                    .reverse = step.reverse,
                                                                    .to_area = to_area_back,
                                                                    .density = density});
    vertex.is_photon = context_.makes_photons(from.bsdf);
    // From here on `from` is the next vertex.
    vertex.point = hit->point;
    vertex.bsdf = hit->bsdf;
    vertex.to_prev = -step.to_next;
    vertex.throughput = vertex.throughput * step.weight;
    vertex.children = context_.children_of_light_vertex(hit->bsdf);
    ++vertex.depth;
    vertex.path = path;
    output_.on_vertex(step, density, vertex, vertex.point);
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

 private:
  /// The light of x_0. `guided` receives what `EmissionGuide::sample` needs.
  template <bool is_guided>
  [[nodiscard]] auto choose_light(T u, [[maybe_unused]] const GuidedLight<T, typename Sc::Light>*& guided) const {
    if constexpr (is_guided)
      return context_.guide->sample_light(context_.scene, u, guided);
    else
      return context_.scene.sample_light(u);
  }
};

}  // namespace gmis
