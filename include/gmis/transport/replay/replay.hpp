#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/transport/state/film_output.hpp"
#include "gmis/transport/walk/camera_subpath.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"

/// \file
/// Traces one path of a run again, alone, with the same random numbers and light trees. Every value
/// equals that of the run, bit by bit. The walks and techniques are those of the engine, compiled a
/// second time for an output that records every vertex.

namespace gmis {

/// A recorded vertex of a subpath.
template <Spectrum S>
struct ReplayedVertex {
  using T = ScalarOf<S>;
  /// No vertex.
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  std::size_t parent = none;                 ///< index in `ReplayedPath::vertices`
  int depth = 0;                             ///< edges from the start of the subpath, which has depth 0
  bool is_at_infinity = false;               ///< the ray left the scene
  SurfacePoint<T> point{};                   ///< all zero at infinity
  Vec3<T> to_prev{};                         ///< unit, towards the parent
  S throughput{T(0)};                        ///< without MIS weights
  bool is_delta = false;                     ///< whether the event at the parent is a delta event
  T forward{};                               ///< nominal density at the parent of coming here, as in `Step`
  T reverse{};                               ///< nominal density at the parent of going back
  T density{};                               ///< expected density of this vertex, per area; 0 at infinity
  std::optional<PartialWeights<T>> weights;  ///< empty at the start, at infinity and after an unusable density
};

/// A recorded contribution and the vertex that made it.
template <Spectrum S>
struct ReplayedContribution {
  using T = ScalarOf<S>;
  Contribution<S> contribution;            ///< what was added
  std::size_t vertex = 0;                  ///< index in `ReplayedPath::vertices`
  std::optional<RejectionCause> rejected;  ///< empty when the contribution reached the film
  /// Position of the other end of a next event, a connection or a merge; empty for other
  /// techniques.
  std::optional<Vec3<T>> position;
  /// Number of the light tree with the other end of a connection or merge, and the depth of the
  /// vertex in that tree.
  std::optional<std::pair<std::uint32_t, int>> light_vertex;
};

/// An unusable density (zero or not finite): that of a vertex, or that of the light sampled for a
/// vertex.
struct ReplayedZeroDensity {
  std::size_t vertex = 0;                ///< index in `ReplayedPath::vertices`
  std::optional<TechniqueId> technique;  ///< empty when the subpath itself ended here
};

/// The record of one path.
template <Spectrum S>
struct ReplayedPath {
  PathName name;                                       ///< which path it is
  std::vector<ReplayedVertex<S>> vertices;             ///< every parent stands before its children
  std::vector<ReplayedContribution<S>> contributions;  ///< in the order in which they were made
  std::vector<ReplayedZeroDensity> zero_densities;     ///< samples whose density was zero
  Counters counters;                                   ///< work of this path alone
  double radius = 0.0;                                 ///< merging radius of the iteration, in scene units
  double vertices_per_tree =
      0.0;                      ///< expected number of stored vertices per light tree; 0 where no count depends on it
  SampleCounts counts;          ///< of the iteration
  S pixel_sum{ScalarOf<S>(0)};  ///< sum of the contributions of a camera subpath to its pixel
};

/// A `PathOutput` that records every vertex and contribution of one path in a `ReplayedPath`.
template <class Context>
class ReplayOutput : public PathObserver {
 public:
  using S = typename Context::S;
  using T = typename Context::T;

  /// Writes what it sees into `path`.
  ReplayOutput(const Context& context, ReplayedPath<S>& path) : context_(context), path_(path) {}

  /// Records the start of the subpath and the throughput that leaves there.
  void on_start(const SurfacePoint<T>& origin, const S& weight) {
    ReplayedVertex<S> start;
    start.point = origin;
    start.throughput = weight;
    path_.vertices.push_back(start);
  }

  /// Records `vertex`, which `step` reached with `density` per area. The subpath ends here when
  /// `density` is unusable.
  void on_vertex(const Step<S>& step, T density, const auto& vertex, const SurfacePoint<T>& point) {
    ReplayedVertex<S> seen = after(step, vertex.throughput, vertex.depth);
    seen.point = point;
    seen.density = density;
    if (is_usable_density(density)) seen.weights = vertex.weights;
    path_.vertices.push_back(seen);
  }

  /// Records the vertex at infinity of a ray that left the scene.
  void on_escape(const Step<S>& step, const S& throughput, int depth) {
    ReplayedVertex<S> seen = after(step, throughput, depth);
    seen.is_at_infinity = true;
    path_.vertices.push_back(seen);
  }

  /// Moves on to the next vertex of a light tree before the techniques work there. Vertices are
  /// used in the order in which they were recorded.
  void on_use(const auto&) { ++at_; }

  /// Names the light vertex at the other end of the contribution that is added next.
  void on_light_vertex(const typename Context::StoredVertex& light) {
    position_ = light.point.position;
    light_vertex_ = {static_cast<std::uint32_t>(context_.light.cache.tree_of(light)), light.depth()};
  }
  /// Names the point on a light at the other end of the contribution that is added next.
  void on_light_point(const SurfacePoint<T>& origin) { position_ = origin.position; }

  // The interface of `PathOutput`: each call is recorded and passed on to a `FilmOutput`, which
  // tests the value.
  /// Records a contribution to the pixel of the path.
  void add(TechniqueId id, const S& value, T weight) {
    note(pixel_, id, value, weight, [&] { film_.add(id, value, weight); });
  }
  /// Records a contribution to another pixel.
  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, T weight) {
    note(pixel, id, value, weight, [&] { film_.add_splat(pixel, id, value, weight); });
  }

  /// A camera subpath starts.
  void begin_pixel(std::uint32_t pixel) {
    pixel_ = pixel;
    film_.begin_pixel(pixel);
  }
  /// The sum that the pixel received.
  [[nodiscard]] const S& take_pixel() { return film_.take_pixel(); }
  /// A chunk of light trees starts.
  constexpr void begin_trees(std::uint32_t first) noexcept { film_.begin_trees(first); }
  /// Counters of the operations of this path.
  [[nodiscard]] constexpr Counters& counters() noexcept { return film_.counters(); }

  /// Records that something was left out.
  void reject(RejectionCause cause, const std::optional<TechniqueId>& technique) {
    film_.reject(cause, technique);
    path_.zero_densities.push_back({path_.vertices.size() - 1, technique});
  }

 private:
  [[nodiscard]] bool is_light() const { return path_.name.kind == PathKind::light; }

  [[nodiscard]] ReplayedVertex<S> after(const Step<S>& step, const S& throughput, int depth) const {
    ReplayedVertex<S> seen;
    seen.parent = is_light() ? at_ : path_.vertices.size() - 1;  // light trees are traced breadth first
    seen.depth = depth;
    seen.to_prev = -step.to_next;
    seen.throughput = throughput;
    seen.is_delta = step.is_delta;
    seen.forward = step.forward;
    seen.reverse = step.reverse;
    return seen;
  }

  template <class Add>
  void note(std::uint32_t pixel, const TechniqueId& id, const S& value, T weight, Add&& add) {
    const std::uint64_t non_finite = counters().rejected_non_finite, negative = counters().rejected_negative;
    add();
    ReplayedContribution<S> made;
    made.contribution = {pixel, id, value, weight};
    made.vertex = is_light() ? at_ : path_.vertices.size() - 1;
    if (counters().rejected_non_finite > non_finite) made.rejected = RejectionCause::non_finite;
    if (counters().rejected_negative > negative) made.rejected = RejectionCause::negative;
    made.position = std::exchange(position_, {});
    made.light_vertex = std::exchange(light_vertex_, {});
    path_.contributions.push_back(made);
  }

  const Context& context_;
  ReplayedPath<S>& path_;
  FilmOutput<S> film_;
  std::uint32_t pixel_ = 0;
  std::size_t at_ = 0;
  std::optional<Vec3<T>> position_;
  std::optional<std::pair<std::uint32_t, int>> light_vertex_;
};

/// Traces one path of the iteration that `engine` is prepared for (`Engine::prepare_replay`): the
/// camera subpath of the pixel with index `number`, which must lie in the crop, or the light tree
/// `number`, which must be below `light_tree_count`. A light tree whose first ray leaves the scene
/// has its start as the only vertex; a tree without an emission sample has no vertex.
template <class Engine>
[[nodiscard]] ReplayedPath<typename Engine::S> replay(const Engine& engine, PathKind kind, std::uint32_t number) {
  using Context = typename Engine::Context;
  const Context context = engine.context();
  ReplayedPath<typename Engine::S> path;
  path.name = {kind, context.keys.iteration, number};
  path.radius = engine.merge_radius(context.keys.iteration);
  path.vertices_per_tree = engine.vertices_per_tree();
  path.counts = engine.counts();
  ReplayOutput<Context> output(context, path);
  if (kind == PathKind::camera) {
    output.begin_pixel(number);
    CameraSubpath<Context, ReplayOutput<Context>> subpath(context, output);
    const auto width = static_cast<std::uint32_t>(context.frame.resolution.x);
    subpath.trace({static_cast<int>(number % width), static_cast<int>(number / width)}, number,
                  Engine::numbers_of(context, kind, number));
    path.pixel_sum = output.take_pixel();
  } else if constexpr (Context::has_light_side) {
    output.begin_trees(number);
    typename Context::MethodType::template LightWalk<Context, ReplayOutput<Context>> tree(context, output);
    tree.trace(Engine::numbers_of(context, kind, number), nullptr);
  }
  path.counters = output.counters();
  return path;
}

}  // namespace gmis
