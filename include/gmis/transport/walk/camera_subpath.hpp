#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gmis/core/transmittance.hpp"
#include "gmis/transport/counts/counted_work.hpp"
#include "gmis/transport/output/path_output.hpp"
#include "gmis/transport/techniques/emitter_hit.hpp"
#include "gmis/transport/walk/context.hpp"
#include "gmis/transport/walk/first_hit.hpp"
#include "gmis/transport/walk/scatter.hpp"

namespace gmis {

namespace detail {
/// Keys of random numbers reserved for each child of a split camera vertex. A vertex uses two keys, one for the
/// techniques and one for scattering, so a subpath of the greatest depth, 256, fits: 2 · 256 < 1024.
inline constexpr std::uint32_t camera_numbers_per_child = 1024;
/// Greatest number of children of one camera subpath that have keys of their own.
inline constexpr std::uint32_t most_camera_children = 16382;
}  // namespace detail

/// Traces the camera subpath of one pixel and applies every technique with a positive count at its vertices. The split
/// policy may give the first non-specular vertex several children; the subpath is then a tree. So may a `CountTable`, at every
/// non-specular vertex.
///
/// Contributions go to `output`, in the unit of the scene's radiance. A sample whose density is zero or not finite ends
/// its subpath and is counted as `RejectionCause::zero_pdf`.
template <class Context, class Output>
class CameraSubpath {
 public:
  using Sc = typename Context::SceneType;
  using S = typename Context::S;
  using T = typename Context::T;
  using Vertex = CameraVertex<Sc, typename Context::Recursion>;
  using CameraPartial = decltype(Vertex::weights);

  CameraSubpath(const Context& context, Output& output) : context_(context), output_(output) {}

  /// Logs the vertices of the next subpaths; null logs none. It has no effect when the context has a `CountTable`.
  void log_to(VertexLog<T>* log) noexcept { log_ = log; }

  /// Traces one subpath through `pixel`. `number` is the index of the pixel in the frame (rows from the upper left).
  /// `source` must be keyed to this pixel, iteration and subpath. Contributions are multiplied by `share`, for a mean of several subpaths.
  template <UniformSource Source>
  void trace(glm::ivec2 pixel, std::size_t number, Source source, T share = T(1)) {
    ++output_.counters().camera_paths;
    if (context_.max_depth < 1) return;
    number_ = number;
    source.at_vertex(0);
    const auto [u, v, u_lens, v_lens] = uniforms<T, 4>(source);
    const auto sample = context_.scene.camera().sample_ray(pixel, Vec2<T>{u, v}, Vec2<T>{u_lens, v_lens});
    if (!sample) return;
    if constexpr (observes_paths<Output>) output_.on_start(sample->origin, sample->weight * share);
    Edge edge{sample->origin,
              {sample->direction, sample->weight, sample->density, T(0), false},
              sample->weight * share,
              {},
              1,
              {},
              false};
    if constexpr (!observes_children<Output>)
      if (context_.count_table != nullptr || log_ != nullptr) [[unlikely]] {
        branches_ = 0;
        if (log_ != nullptr) log_->begin_path();
        follow_counted(edge, source, 0);
        if (log_ != nullptr) log_->end_path(mean_channel(output_.take_pixel()), output_.counters());
        return;
      }
    if (is_plain()) [[likely]]
      follow_plain(edge, source);
    else
      follow_general(edge, source, 0);
  }

 private:
  /// The edge from one vertex to the next.
  struct Edge {
    SurfacePoint<T> from;
    Step<S> step;
    S throughput;                  ///< at the far end
    CameraPartial weights_behind;  ///< partial weights at `from`
    std::int16_t depth;            ///< of the far end: edges from the camera
    HalfPath path{};               ///< the events at `from` and before it
    bool has_branched;             ///< `from` or a vertex before it has had its children
  };

  /// `plain`: subpaths that are neither split nor ended at the first non-specular vertex, in a run that does not
  /// classify paths. Nearly all subpaths are plain. They are compiled separately, so that a vertex skips the tests for
  /// the rest. `counted`: subpaths with a `CountTable` or a log, whose nominal numbers of children are those of plain ones.
  enum class Walk { plain, general, counted };
  [[nodiscard]] constexpr bool is_plain() const noexcept {
    return context_.counts.camera_children == 1 && !context_.filter.classifies() && !observes_children<Output>;
  }

  /// Inlines everything it calls, because nearly all time is spent here.
  template <UniformSource Source>
  [[gnu::flatten]] void follow_plain(Edge& edge, Source& source) {
    follow<Walk::plain>(edge, source, 0);
  }
  template <UniformSource Source>
  [[gnu::noinline]] void follow_general(Edge& edge, Source& source, std::uint32_t first_number) {
    follow<Walk::general>(edge, source, first_number);
  }
  template <UniformSource Source>
  [[gnu::noinline, gnu::flatten]] void follow_counted(Edge& edge, Source& source, std::uint32_t first_number) {
    follow<Walk::counted>(edge, source, first_number);
  }

  /// Traces the subpath from `edge` to its end. Overwrites `edge`.
  template <Walk walk, UniformSource Source>
  void follow(Edge& edge, Source& source, std::uint32_t first_number) {
    for (;; ++edge.depth) {  // returns at `max_depth` at the latest
      ++output_.counters().rays;
      auto hit = context_.scene.intersect(leave(edge.from, edge.step.to_next));
      if (edge.depth == 1) pass_start(context_.scene, edge.from, edge.step.to_next, hit);
      if (!hit) {
        escape(edge);
        return;
      }
      if (absorbs(context_.scene)) [[unlikely]]
        attenuate(context_.scene, edge.from, edge.step.to_next, hit->point.position, edge.throughput);
      Vertex vertex{*hit, -edge.step.to_next, edge.throughput, {}, {}, edge.depth, edge.path};
      if (!arrive(edge, vertex)) return;
      if (context_.has.emitter_hit && vertex.hit.light != nullptr)
        EmitterHit::at_camera_vertex(context_, vertex, weights_of_hit(edge, vertex), edge.from, output_);
      if (edge.depth == context_.max_depth) return;

      const auto& bsdf = vertex.hit.bsdf;
      const T survival = survival_probability(bsdf);
      if (survival == T(0)) return;  // the surface absorbs everything
      const bool is_specular = bsdf.is_purely_delta();
      // Nothing but the first non-specular vertex of a subpath has several children. Where none has, all vertices are alike.
      const bool may_branch = walk == Walk::general && !is_specular && !edge.has_branched;
      const T light_children = context_.light_children(bsdf, survival);
      const bool is_plain = walk != Walk::general;
      vertex.children = {is_plain ? survival : context_.camera_children(survival, may_branch), light_children};
      const std::uint32_t number = first_number + 2 * static_cast<std::uint32_t>(edge.depth);
      [[maybe_unused]] int counted_children = 1;
      if (!is_specular &&
          (walk == Walk::plain || context_.filter.keeps_camera(context_.filter.after_scattering(edge.path, bsdf)))) {
        if constexpr (walk == Walk::counted)
          counted_children = at_counted_vertex(edge, vertex, source, number);
        else
          at_vertex(vertex, source, number);
      }

      const ScatteringVertex<typename Sc::Bsdf> scattering{
          bsdf,
          vertex.hit.point,
          vertex.to_prev,
          TransportMode::radiance,
          survival,
          vertex.children,
          {is_plain ? survival : context_.camera_delta_children(survival, may_branch), light_children}};
      if (may_branch)
        if (const int children = context_.split.camera_children(number_); children > 1 || observes_children<Output>) {
          branch(edge, vertex, scattering, children, source, number + 1);
          return;
        }
      source.at_vertex(number + 1);
      if constexpr (walk == Walk::counted) {
        if (counted_children == 0) return;
        if (counted_children > 1) branch_off(edge, vertex, scattering, counted_children - 1, source);
      }
      const auto next = scatter<Context::has_light_side>(scattering, source);
      if (!next) return;
      if constexpr (walk != Walk::plain) {
        if (context_.camera_stops() && !next->is_delta) return;
        edge.path = context_.filter.after_event(edge.path, bsdf, next->is_delta);
        if (!context_.filter.keeps_camera(edge.path)) return;
      }
      edge.step = *next;
      edge.throughput = edge.throughput * next->weight;
      edge.from = vertex.hit.point;
      edge.weights_behind = vertex.weights;
    }
  }

  /// Traces all children of the first non-specular vertex. Each child has random numbers of its own.
  template <UniformSource Source>
  [[gnu::noinline]] void branch(const Edge& edge, const Vertex& vertex,
                                const ScatteringVertex<typename Sc::Bsdf>& scattering, int count, Source& source,
                                std::uint32_t number) {
    Source children = source;
    children.at_vertex(number);
    std::uint32_t child = 0;
    context_.split.expand_camera(scattering, count, children, [&](const Step<S>& step) {
      ++child;
      const HalfPath path = context_.filter.after_event(edge.path, vertex.hit.bsdf, step.is_delta);
      if (!context_.filter.keeps_camera(path)) return;
      Edge next{vertex.hit.point, step, edge.throughput * step.weight, vertex.weights, edge.depth, path, true};
      ++next.depth;
      if constexpr (observes_children<Output>) output_.begin_child(edge.depth);
      follow_general(next, source, detail::camera_numbers_per_child * child);
    });
    if constexpr (observes_children<Output>) output_.end_children();
  }

  /// Traces `count` more children of a vertex. Each child has random numbers of its own, and so has what comes after.
  template <UniformSource Source>
  [[gnu::noinline]] void branch_off(const Edge& edge, const Vertex& vertex,
                                    const ScatteringVertex<typename Sc::Bsdf>& scattering, int count, Source& source) {
    std::uint32_t first_number = 0;
    for (; count > 0; --count) {
      first_number = detail::camera_numbers_per_child * ++branches_;
      source.at_vertex(first_number);
      const auto step = scatter<Context::has_light_side>(scattering, source);
      if (!step) continue;
      const HalfPath path = context_.filter.after_event(edge.path, vertex.hit.bsdf, step->is_delta);
      if (!context_.filter.keeps_camera(path)) continue;
      Edge child{vertex.hit.point, *step, edge.throughput * step->weight, vertex.weights, edge.depth, path, true};
      ++child.depth;
      follow_counted(child, source, first_number);
    }
    source.at_vertex(first_number + 1);  // a vertex of the child has larger numbers
  }

  /// Forms the partial weights of the vertex from its density per area. Returns false and rejects the sample when the
  /// density is zero or not finite.
  [[nodiscard]] bool arrive(const Edge& edge, Vertex& vertex) {
    const Vec3<T> offset = vertex.hit.point.position - edge.from.position;
    const T distance_squared = glm::dot(offset, offset);
    const T density = density_at(edge, vertex, distance_squared);
    if (!is_usable_density(density)) [[unlikely]] {
      if constexpr (observes_paths<Output>) output_.on_vertex(edge.step, density, vertex, vertex.hit.point);
      output_.reject(RejectionCause::zero_pdf, {});
      return false;
    }
    vertex.weights =
        weights_at(edge, cos_behind(edge) / distance_squared, density, context_.makes_photons(vertex.hit.bsdf));
    if constexpr (observes_paths<Output>) output_.on_vertex(edge.step, density, vertex, vertex.hit.point);
    return true;
  }

  /// Adds the radiance of infinite lights to an escaped subpath. The vertex at infinity keeps its density per
  /// steradian; g at the near end of the edge is |cos|, without a distance.
  void escape(const Edge& edge) {
    if constexpr (observes_paths<Output>) output_.on_escape(edge.step, edge.throughput, edge.depth);
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

  /// Partial weights at the far end. `to_area_back` is g at the near end, `density` is b at the far end,
  /// `makes_photons` is s there [Georgiev TR 31–36, mirrored].
  [[nodiscard]] CameraPartial weights_at(const Edge& edge, T to_area_back, T density, bool makes_photons) const {
    if (edge.depth == 1) return context_.recursion.first_camera_vertex(density);
    return context_.recursion.extend_camera(edge.weights_behind, edge.depth == 2, makes_photons, edge.step.is_delta,
                                            edge.step.reverse, to_area_back, density);
  }

  /// Partial weights at `vertex` as the end x_0 of a path, on a light. They differ from those of the vertex only when its
  /// surface makes photons and its light does not.
  [[nodiscard]] CameraPartial weights_of_hit(const Edge& edge, const Vertex& vertex) const {
    if constexpr (Context::has_light_side)
      if (context_.makes_photons(vertex.hit.bsdf) != context_.lights_make_photons()) {
        const Vec3<T> offset = vertex.hit.point.position - edge.from.position;
        const T distance_squared = glm::dot(offset, offset);
        return weights_at(edge, cos_behind(edge) / distance_squared, density_at(edge, vertex, distance_squared), false);
      }
    return vertex.weights;
  }

  /// b_j = c ψ(x_{j+1} → x_j) |cos θ_j| / d², c being part of `forward`. With parallel camera rays, b_{k−1} is the
  /// density per area perpendicular to the ray, times |cos θ_{k−1}|.
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
    if constexpr (observes_children<Output>) output_.end_vertex();
  }

  /// Applies the techniques of a non-specular vertex with its counts, or logs them. Returns the number of children; `edge` then has
  /// the throughput of each without its step.
  template <UniformSource Source>
  [[nodiscard]] int at_counted_vertex(Edge& edge, Vertex& vertex, Source& source, std::uint32_t number) {
    source.at_vertex(number);
    if (context_.count_table == nullptr) {
      logged_work(context_, *log_, vertex, number_, source, output_);
      return 1;
    }
    constexpr auto children = static_cast<std::size_t>(VertexWork::children);
    const bool may_branch = branches_ < detail::most_camera_children - static_cast<std::uint32_t>(CountTable<T>::most);
    const auto counts = draw_counts(context_, *context_.count_table, vertex, number_, may_branch, source);
    counted_work(context_, counts, vertex, number_, source, output_);
    if (counts.expected[children] != T(1)) edge.throughput = edge.throughput * (T(1) / counts.expected[children]);
    return counts.drawn[children];
  }

  const Context& context_;
  Output& output_;
  std::size_t number_ = 0;
  VertexLog<T>* log_ = nullptr;
  std::uint32_t branches_ = 0;  // children of the present subpath with keys of their own
};

}  // namespace gmis
