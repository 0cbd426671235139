#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gmis/core/attributes.hpp"
#include "gmis/core/transmittance.hpp"
#include "gmis/transport/context/iteration_context.hpp"
#include "gmis/transport/state/first_hit.hpp"
#include "gmis/transport/state/path_output.hpp"
#include "gmis/transport/state/scatter.hpp"
#include "gmis/transport/techniques/connect.hpp"
#include "gmis/transport/techniques/emitter_hit.hpp"
#include "gmis/transport/techniques/merge.hpp"
#include "gmis/transport/techniques/next_event.hpp"
#include "gmis/transport/walk/hot_walk.hpp"

namespace gmis {

/// Traces the camera subpath of one pixel and applies every technique with a positive count at its
/// vertices.
///
/// Contributions go to `output`, in the unit of the scene's radiance. A sample whose density is
/// zero or not finite ends its subpath and is counted as `RejectionCause::zero_pdf`.
template <class Context, class Output>
class CameraSubpath {
 public:
  using Sc = typename Context::SceneType;
  using S = typename Context::S;
  using T = typename Context::T;
  using Vertex = CameraVertex<Sc, typename Context::Recursion>;
  using CameraPartial = decltype(Vertex::weights);

  CameraSubpath(const Context& context, Output& output) : context_(context), output_(output) {}

  /// Traces one subpath through `pixel`. `number` is the index of the pixel in the frame (rows from
  /// the upper left). `source` must be keyed to this pixel and iteration.
  template <UniformSource Source>
  void trace(glm::ivec2 pixel, std::size_t number, Source source) {
    ++output_.counters().camera_paths;
    if (context_.max_depth < 1) return;
    number_ = number;
    source.at_vertex(0);
    const auto [u, v, u_lens, v_lens] = uniforms<T, 4>(source);
    const auto sample = context_.scene.camera().sample_ray(pixel, Vec2<T>{u, v}, Vec2<T>{u_lens, v_lens});
    if (!sample) return;
    output_.on_start(sample->origin, sample->weight);
    Edge edge{
        sample->origin, {sample->direction, sample->weight, sample->density, T(0), false}, sample->weight, {}, 1, {}};
    if constexpr (detail::is_hot_walk<Context, Output>)
      if (context_.counts.extends_camera && !context_.filter.classifies()) [[likely]] {
        follow_plain(edge, source);
        return;
      }
    follow_general(edge, source);
  }

 private:
  /// The edge from one vertex to the next.
  struct Edge {
    SurfacePoint<T> from;
    Step<S> step;
    S throughput;                  ///< at the far end
    CameraPartial weights_behind;  ///< partial weights at `from`
    std::int16_t depth;            ///< edges from the camera to the far end
    HalfPath path{};               ///< the events at `from` and before it
    bool is_specular = true;       ///< all events up to `from` are specular
  };

  /// Subpaths that do not end at the first non-specular vertex, in a run that does not classify
  /// paths: nearly all. They are compiled apart, so that a vertex skips the tests for the rest, and
  /// flat, because nearly all time is spent here.
  template <UniformSource Source>
  GMIS_FLATTEN void follow_plain(Edge& edge, Source& source) {
    follow<true>(edge, source);
  }
  template <UniformSource Source>
  GMIS_NEVER_INLINE void follow_general(Edge& edge, Source& source) {
    follow<false>(edge, source);
  }

  /// Traces the subpath from `edge` to its end. Overwrites `edge`.
  template <bool is_plain, UniformSource Source>
  void follow(Edge& edge, Source& source) {
    for (;; ++edge.depth) {  // returns at `max_depth` at the latest
      ++output_.counters().rays;
      auto hit = context_.scene.intersect(leave(edge.from, edge.step.to_next));
      if (edge.depth == 1) pass_start(context_.scene, edge.from, edge.step.to_next, hit);
      if (!hit) {
        escape(edge);
        return;
      }
      if (absorbs(context_.scene)) [[unlikely]]
        attenuate(context_.scene, edge.from, edge.step.to_next, hit->point, edge.throughput);
      Vertex vertex{*hit, -edge.step.to_next, edge.throughput, {}, {}, edge.depth, edge.path};
      if (!arrive(edge, vertex)) return;
      if (context_.has.emitter_hit && vertex.hit.light != nullptr)
        EmitterHit::at_camera_vertex(context_, vertex, weights_of_hit(edge, vertex), edge.from, output_);
      if (edge.depth == context_.max_depth) return;

      const auto& bsdf = vertex.hit.bsdf;
      const T light_survival = survival_probability(bsdf);
      if (light_survival == T(0)) return;  // the surface absorbs everything
      const T survival = edge.is_specular ? T(1) : camera_survival(light_survival);
      const T light_children = context_.light_children(bsdf, light_survival);
      vertex.children = {is_plain ? survival : context_.camera_children(survival), light_children};
      const auto number = 2 * static_cast<std::uint32_t>(edge.depth);  // keys the random numbers of the vertex
      if (!bsdf.is_purely_delta() &&
          (is_plain || context_.filter.keeps_camera(context_.filter.after_scattering(edge.path, bsdf))))
        at_vertex(vertex, source, number);

      source.at_vertex(number + 1);
      const auto next =
          scatter<Context::has_light_side>(ScatteringVertex<typename Sc::Bsdf>{bsdf,
                                                                               vertex.hit.point,
                                                                               vertex.to_prev,
                                                                               TransportMode::radiance,
                                                                               survival,
                                                                               vertex.children,
                                                                               {survival, light_children}},
                                           source);
      if (!next) return;
      if constexpr (!is_plain) {
        if (!context_.counts.extends_camera && !next->is_delta) return;
        edge.path = context_.filter.after_event(edge.path, bsdf, next->is_delta);
        if (!context_.filter.keeps_camera(edge.path)) return;
      }
      edge.is_specular = edge.is_specular && next->is_delta;
      edge.step = *next;
      edge.throughput = edge.throughput * next->weight;
      edge.from = vertex.hit.point;
      edge.weights_behind = vertex.weights;
    }
  }

  /// Forms the partial weights of the vertex from its density per area. Returns false and rejects
  /// the sample when the density is zero or not finite.
  [[nodiscard]] bool arrive(const Edge& edge, Vertex& vertex) {
    const Vec3<T> offset = vertex.hit.point.position - edge.from.position;
    const T distance_squared = glm::dot(offset, offset);
    const T density = density_at(edge, vertex, distance_squared);
    if (!is_usable_density(density)) [[unlikely]] {
      output_.on_vertex(edge.step, density, vertex, vertex.hit.point);
      output_.reject(RejectionCause::zero_pdf, {});
      return false;
    }
    vertex.weights =
        weights_at(edge, cos_behind(edge) / distance_squared, density, context_.makes_photons(vertex.hit.bsdf));
    output_.on_vertex(edge.step, density, vertex, vertex.hit.point);
    return true;
  }

  /// Adds the radiance of infinite lights to an escaped subpath. The vertex at infinity keeps its
  /// density per steradian; g at the near end of the edge is |cos|, without a distance.
  void escape(const Edge& edge) {
    output_.on_escape(edge.step, edge.throughput, edge.depth);
    if (context_.has.emitter_hit) {
      if (is_usable_density(edge.step.forward)) [[likely]]
        EmitterHit::at_escape(context_, -edge.step.to_next, edge.throughput,
                              weights_at(edge, cos_behind(edge), edge.step.forward, context_.lights_make_photons()),
                              edge.depth, edge.path, edge.from, output_);
      else
        output_.reject(RejectionCause::zero_pdf, {});
    }
  }

  /// |cos| between the edge and the geometric normal at its near end.
  [[nodiscard]] static constexpr T cos_behind(const Edge& edge) noexcept {
    return std::abs(glm::dot(edge.from.geometric_normal, edge.step.to_next));
  }

  /// Partial weights at the far end. `to_area_back` is g at the near end, `density` is b at the far
  /// end, `makes_photons` is s there [Georgiev TR 31–36, mirrored].
  [[nodiscard]] CameraPartial weights_at(const Edge& edge, T to_area_back, T density, bool makes_photons) const {
    if (edge.depth == 1) return context_.recursion.first_camera_vertex(density);
    return context_.recursion.extend_camera(edge.weights_behind, {.is_next_to_camera = edge.depth == 2,
                                                                  .makes_photons = makes_photons,
                                                                  .is_delta = edge.step.is_delta,
                                                                  .reverse = edge.step.reverse,
                                                                  .to_area = to_area_back,
                                                                  .density = density});
  }

  /// Partial weights at `vertex` as the end x_0 of a path, on a light. They differ from those of
  /// the vertex only when its surface makes photons and its light does not.
  [[nodiscard]] CameraPartial weights_of_hit(const Edge& edge, const Vertex& vertex) const {
    if constexpr (Context::has_light_side)
      if (context_.makes_photons(vertex.hit.bsdf) != context_.lights_make_photons()) {
        const Vec3<T> offset = vertex.hit.point.position - edge.from.position;
        const T distance_squared = glm::dot(offset, offset);
        return weights_at(edge, cos_behind(edge) / distance_squared, density_at(edge, vertex, distance_squared), false);
      }
    return vertex.weights;
  }

  /// b_j = c ψ(x_{j+1} → x_j) |cos θ_j| / d², c being part of `forward`. With parallel camera rays,
  /// b_{k−1} is the density per area perpendicular to the ray, times |cos θ_{k−1}|.
  [[nodiscard]] T density_at(const Edge& edge, const Vertex& vertex, T distance_squared) const {
    const T cos_here = std::abs(glm::dot(vertex.hit.point.geometric_normal, edge.step.to_next));
    const bool is_parallel = edge.depth == 1 && context_.scene.camera().has_parallel_rays();
    return edge.step.forward * (is_parallel ? cos_here : cos_here / distance_squared);
  }

  /// Applies the techniques of a non-specular vertex. `number` keys their random numbers.
  template <UniformSource Source>
  void at_vertex(const Vertex& vertex, Source& source, std::uint32_t number) {
    source.at_vertex(number);
    if (context_.has.next_event) NextEvent::at_camera_vertex(context_, vertex, source, output_);
    if constexpr (Context::has_light_side) {
      if (context_.has.connect) Connect::at_camera_vertex(context_, vertex, number_, source, output_);
      if (context_.has.merge) Merge::at_camera_vertex(context_, vertex, output_);
    }
    output_.end_vertex();
  }

  const Context& context_;
  Output& output_;
  std::size_t number_ = 0;
};

}  // namespace gmis
