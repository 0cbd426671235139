#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/transport/output/film_output.hpp"
#include "gmis/transport/walk/camera_subpath.hpp"
#include "gmis/transport/walk/light_tree.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"

/// \file
/// One path of a run traced again, alone: the same random numbers over the same light trees, so that every number is the
/// run's own, bit by bit. The walks and techniques are those of the engine, compiled a second time for an output that
/// looks on.

namespace gmis {

/// A vertex as a subpath found it.
template <Spectrum S>
struct ReplayedVertex {
  using T = ScalarOf<S>;
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  std::size_t parent = none;  ///< by its place in `ReplayedPath::vertices`
  int depth = 0;              ///< edges from the start; that has 0
  bool is_at_infinity = false;
  SurfacePoint<T> point;   ///< nothing at infinity
  Vec3<T> to_prev{};       ///< unit, towards the parent
  S throughput{T(0)};      ///< without weights
  bool is_delta = false;   ///< the event at the parent
  T forward{}, reverse{};  ///< at the parent: nominal densities of coming here and of going back, as `Step` has them
  T density{};             ///< expected of this vertex, per unit area; 0 at infinity
  std::optional<PartialWeights<T>> weights;  ///< none where no techniques are weighted
};

/// A contribution and where it was made.
template <Spectrum S>
struct ReplayedContribution {
  using T = ScalarOf<S>;
  Contribution<S> contribution;
  std::size_t vertex = 0;  ///< of the path, by its place
  std::optional<RejectionCause> rejected;
  /// The other end of a next event, a connection or a merge …
  std::optional<Vec3<T>> position;
  /// … and the light tree that has it, with its depth there.
  std::optional<std::pair<std::uint32_t, int>> light_vertex;
};

/// Where a density was of no use: the vertex's own, or that of the light sampled for it.
struct ReplayedZeroDensity {
  std::size_t vertex = 0;
  std::optional<TechniqueId> technique;  ///< none: the subpath itself ended here
};

template <Spectrum S>
struct ReplayedPath {
  PathName name;
  std::vector<ReplayedVertex<S>> vertices;  ///< of a tree, every parent before its children
  std::vector<ReplayedContribution<S>> contributions;
  std::vector<ReplayedZeroDensity> zero_densities;
  Counters counters;  ///< what this path alone took
  // As in the run:
  double radius = 0.0;             ///< of merging
  double vertices_per_tree = 0.0;  ///< expected; 0 where no count depends on it
  SampleCounts counts;
  S pixel_sum{ScalarOf<S>(0)};  ///< of a camera path: what it adds to its pixel
};

/// Looks on while a path is traced.
template <class Context>
class ReplayOutput {
 public:
  using ObservesPaths = void;
  using S = typename Context::S;
  using T = typename Context::T;

  ReplayOutput(const Context& context, ReplayedPath<S>& path) : context_(context), path_(path) {}

  /// The subpath's start: what leaves there.
  void on_start(const SurfacePoint<T>& origin, const S& weight) {
    ReplayedVertex<S> start;
    start.point = origin;
    start.throughput = weight;
    path_.vertices.push_back(start);
  }

  /// `vertex` was reached by `step`; `density` may be of no use, then the subpath ends.
  void on_vertex(const Step<S>& step, T density, const auto& vertex, const SurfacePoint<T>& point) {
    ReplayedVertex<S> seen = after(step, vertex.throughput, vertex.depth);
    seen.point = point;
    seen.density = density;
    if (is_usable_density(density)) seen.weights = vertex.weights;
    path_.vertices.push_back(seen);
  }

  void on_escape(const Step<S>& step, const S& throughput, int depth) {
    ReplayedVertex<S> seen = after(step, throughput, depth);
    seen.is_at_infinity = true;
    path_.vertices.push_back(seen);
  }

  /// The techniques are about to work at the next vertex of a light tree; they come in the order in which they were found.
  void on_use(const typename Context::StoredVertex&) { ++at_; }

  void on_light_vertex(const typename Context::StoredVertex& light) {
    position_ = light.point.position;
    light_vertex_ = {static_cast<std::uint32_t>(context_.cache.tree_of(light)), light.depth};
  }
  void on_light_point(const SurfacePoint<T>& origin) { position_ = origin.position; }

  void add(TechniqueId id, const S& value, T weight) {
    note(pixel_, id, value, weight, [&] { film_.add(id, value, weight); });
  }
  void add_splat(std::uint32_t pixel, TechniqueId id, const S& value, T weight) {
    note(pixel, id, value, weight, [&] { film_.add_splat(pixel, id, value, weight); });
  }

  void begin_pixel(std::uint32_t pixel) {
    pixel_ = pixel;
    film_.begin_pixel(pixel);
  }
  [[nodiscard]] const S& take_pixel() { return film_.take_pixel(); }
  void begin_trees(std::uint32_t first) noexcept { film_.begin_trees(first); }
  [[nodiscard]] Counters& counters() noexcept { return film_.counters(); }

  void reject(RejectionCause cause, const std::optional<TechniqueId>& technique) {
    film_.reject(cause, technique);
    path_.zero_densities.push_back({path_.vertices.size() - 1, technique});
  }

 private:
  [[nodiscard]] bool is_light() const { return path_.name.kind == PathKind::light; }

  /// Light trees are walked level by level, camera subpaths branch by branch.
  [[nodiscard]] std::size_t parent_of(int depth) const {
    if (is_light()) return at_;
    std::size_t parent = path_.vertices.size() - 1;
    while (path_.vertices[parent].depth != depth - 1) --parent;
    return parent;
  }

  [[nodiscard]] ReplayedVertex<S> after(const Step<S>& step, const S& throughput, int depth) const {
    ReplayedVertex<S> seen;
    seen.parent = parent_of(depth);
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

/// The camera subpath of a pixel, or a light tree, of the iteration that `engine` is ready for (`Engine::prepare_replay`).
/// The pixel must lie in the crop, the number below that of the trees. Only what the walk meets is there: a subpath that
/// leaves the scene from a light, or that no light is chosen for, has no more than its start.
template <class Engine>
[[nodiscard]] ReplayedPath<typename Engine::S> replay(const Engine& engine, PathKind kind, std::uint32_t number) {
  using Context = typename Engine::Context;
  const Context context = engine.context();
  ReplayedPath<typename Engine::S> path;
  path.name = {kind, context.iteration, number};
  path.radius = engine.merge_radius(context.iteration);
  path.vertices_per_tree = engine.vertices_per_tree();
  path.counts = engine.counts();
  ReplayOutput<Context> output(context, path);
  const auto source = Engine::numbers_of(context, kind, number);
  if (kind == PathKind::camera) {
    output.begin_pixel(number);
    CameraSubpath<Context, ReplayOutput<Context>> subpath(context, output);
    const auto pixel = static_cast<int>(number);
    subpath.trace({pixel % context.resolution.x, pixel / context.resolution.x}, number, source);
    path.pixel_sum = output.take_pixel();
  } else if constexpr (Context::has_light_side) {
    output.begin_trees(number);
    LightTree<Context, ReplayOutput<Context>> tree(context, output);
    tree.trace(source, nullptr);
  }
  path.counters = output.counters();
  return path;
}

}  // namespace gmis
