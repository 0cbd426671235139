#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/transport/camera_subpaths.hpp"
#include "gmis/transport/contribution.hpp"
#include "gmis/transport/integrator.hpp"
#include "gmis/transport/iteration_context.hpp"
#include "gmis/transport/light_subpaths.hpp"
#include "gmis/transport/settings.hpp"
#include "gmis/transport/tuning.hpp"

namespace gmis {

/// Seconds spent in each phase, summed over iterations, as seen by the calling thread.
struct PhaseSeconds {
  double light = 0.0;
  double grid = 0.0;
  double camera = 0.0;
  double film = 0.0;

  PhaseSeconds& operator+=(const PhaseSeconds& other) noexcept {
    light += other.light;
    grid += other.grid;
    camera += other.camera;
    film += other.film;
    return *this;
  }
};

/// The one engine behind all integrators: an iteration traces the light trees, builds the grid, then traces one camera
/// subpath a pixel; whatever the integrator's techniques do not need is not compiled in. Work is cut into chunks of
/// fixed size and merged in their order, so that the same seed gives the same bits for any number of threads.
///
/// Counts that are to follow measured efficiency (`Tuner`) are tried out in the first iterations, on what is rendered:
/// a crop may choose otherwise than the whole image. With fixed counts a crop has the same bits as the whole.
///
/// `records_techniques` keeps every contribution of the latest iteration with the technique that made it
/// (`for_each_contribution`), for images of single techniques.
template <Scene Sc, class Integrator_, bool records_techniques = false, class Source = Philox>
class Engine {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Context = IterationContext<Sc, Integrator_>;
  using StoredVertex = typename Context::StoredVertex;

  Engine(const Sc& scene, const RenderSettings& settings, std::optional<PixelBounds> crop = std::nullopt)
      : scene_(scene), settings_(settings), resolution_(scene.camera().resolution()) {
    crop_ = crop.value_or(PixelBounds{{0, 0}, resolution_});
    crop_.lower = glm::max(crop_.lower, glm::ivec2(0));
    crop_.upper = glm::min(crop_.upper, resolution_);
    const auto pixels = static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y);
    frame_.assign(pixels, S(T(0)));
    if constexpr (Integrator_::traces_light) {
      light_tree_count_ =
          static_cast<std::size_t>(std::max(1.0, std::round(settings.light_paths * static_cast<double>(pixels))));
      const std::size_t chunk_count = (light_tree_count_ + chunk_size - 1) / chunk_size;
      light_outputs_.resize(chunk_count);
      cache_.resize(chunk_count, chunk_size);
    }
    camera_outputs_.resize(static_cast<std::size_t>(std::max(0, crop_.upper.y - crop_.lower.y)));
    split_ = Policy(settings);
    tuner_ = Tuner<S>(settings, Integrator_::template has<Connect>, Integrator_::Split::splits_light);
  }

  /// Renders one more iteration; the image it alone gives is `frame()` afterwards.
  template <Executor E>
  void iterate(E& executor) {
    const Counters before = counters_;
    begin_iteration(executor);
    trace_camera(executor, context());
    if constexpr (Integrator_::template has<Splat>) add_splats();
    for (const Output& output : light_outputs_) rejections_.append(output.rejections, iteration_);
    for (const Output& output : camera_outputs_) rejections_.append(output.rejections, iteration_);
    if (!tuner_.is_settled()) tuner_.report(frame_, counters_ - before);
  }

  /// Lets an engine that has rendered nothing yet go on where another one stopped: it uses none of the other's random
  /// numbers, and its merging radius shrinks on from there.
  void continue_after(std::uint32_t iteration) noexcept { iteration_ = iteration; }

  /// Makes an engine that has rendered nothing yet ready to trace paths of `iteration` as it would have done on the way
  /// (replay.hpp): renders those of the iterations before in which counts are measured, and traces the light trees. The
  /// same iteration may be prepared again, another one not.
  template <Executor E>
  void prepare_replay(E& executor, std::uint32_t iteration) {
    while (!tuner_.is_settled() && iteration_ + 1 < iteration) iterate(executor);
    iteration_ = iteration - 1;
    begin_iteration(executor);
  }

  /// Whether contributions are kept from the next iteration on (they are, in an engine that records techniques): lets a
  /// program that records only now and then do with one engine.
  void keep_contributions(bool keep) noexcept {
    static_assert(records_techniques, "this engine does not record techniques");
    for (Output& output : light_outputs_) output.is_recording = keep;
    for (Output& output : camera_outputs_) output.is_recording = keep;
  }

  /// Calls `visit(output)` for every chunk of the light side, then of the camera side, in a fixed order.
  template <class Visit>
  void for_each_output(Visit&& visit) {
    for (Output& output : light_outputs_) visit(output);
    for (Output& output : camera_outputs_) visit(output);
  }

  /// Linear values by rows from the upper left; pixels outside the crop stay black.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  [[nodiscard]] std::uint32_t iteration() const noexcept { return iteration_; }
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }
  /// The part of them that tracing light trees took.
  [[nodiscard]] const Counters& light_work() const noexcept { return light_work_; }
  /// The first paths of which something was left out.
  [[nodiscard]] const RejectionLog& rejections() const noexcept { return rejections_; }
  [[nodiscard]] const PhaseSeconds& seconds() const noexcept { return seconds_; }
  /// The counts that the latest iteration was made with.
  [[nodiscard]] const Tuning& tuning() const noexcept { return tuning_; }
  /// V̄ / n_L: stored vertices that a light tree is expected to have, as measured before the first iteration where counts
  /// depend on it (else 0).
  [[nodiscard]] double vertices_per_tree() const noexcept { return vertices_per_tree_; }
  /// How they were, or are being, chosen.
  [[nodiscard]] const Tuner<S>& tuner() const noexcept { return tuner_; }

  /// r_i = r_1 i^((α−1)/2) [Hachisuka, Jensen 2009, as Georgiev 2012 eq. 13].
  [[nodiscard]] double merge_radius(std::uint32_t iteration) const noexcept {
    return settings_.radius * std::pow(static_cast<double>(iteration), 0.5 * (settings_.alpha - 1.0));
  }

  /// Bytes held for light vertices and their grid.
  [[nodiscard]] std::size_t photon_bytes() const noexcept {
    return Integrator_::stores_light_vertices ? grid_.byte_count() + cache_.byte_count() : 0;
  }

  /// What all techniques read at the latest iteration's camera vertices. Holds references into this engine.
  [[nodiscard]] Context context() const { return context_for(iteration_, static_cast<T>(merge_radius(iteration_))); }
  /// The random numbers of a path of that context.
  [[nodiscard]] static Source numbers_of(const Context& context, PathKind kind, std::uint32_t number) {
    return Source(context.seed, context.iteration, number, kind == PathKind::light ? light_stream : camera_stream);
  }
  [[nodiscard]] std::size_t light_tree_count() const noexcept { return light_tree_count_; }

  /// Whether anything is done at this vertex of a light subpath.
  [[nodiscard]] static bool is_worth_storing(const StoredVertex& vertex) noexcept {
    return !vertex.bsdf.is_purely_delta() && survival_probability(vertex.bsdf) > T(0);
  }

  /// Calls `visit(const Contribution<S>&)` for every contribution of the latest iteration, in a fixed order.
  template <class Visit>
  void for_each_contribution(Visit&& visit) const {
    static_assert(records_techniques, "this engine does not record techniques");
    for (const Output& output : light_outputs_)
      for (const auto& record : output.records()) visit(record);
    for (const Output& output : camera_outputs_)
      for (const auto& record : output.records()) visit(record);
  }

 private:
  static constexpr std::size_t chunk_size = 256;
  static constexpr std::size_t pilot_tree_count = 4096;
  enum Stream : std::uint32_t { light_stream = 0, camera_stream = 1, pilot_stream = 2 };

  using Output = typename Integrator_::template Output<S, records_techniques>;
  using LightTree = gmis::LightTree<Context, Output>;

  using Policy = typename Integrator_::Split::template Policy<T>;

  /// Everything of the next iteration that comes before its camera subpaths.
  template <Executor E>
  void begin_iteration(E& executor) {
    if (!is_tuned_) {
      tune(executor, tuner_.current());
      is_tuned_ = tuner_.is_settled();
    }
    ++iteration_;
    if constexpr (Integrator_::traces_light) {
      trace_light(executor, context());
      if constexpr (Integrator_::template has<Merge>) build_grid(static_cast<T>(merge_radius(iteration_)));
    }
  }

  /// Makes `tuning` the one to work with, and measures what must be known for it before the first iteration: the mean
  /// numbers of children and of vertices of a tree, from light trees whose random numbers are used for nothing else.
  template <Executor E>
  void tune(E& executor, const Tuning& tuning) {
    const bool keeps_trees = knows_trees_ && tuning.light_children == tuning_.light_children;
    tuning_ = tuning;
    split_.plan(tuning);
    if constexpr (Integrator_::template has<Connect> || (Integrator_::traces_light && Integrator_::Split::splits_light))
      if (!keeps_trees && (Integrator_::Split::splits_light || tuning.connections != paired_connections)) {
        measure_light_trees(executor);
        knows_trees_ = true;
      }
  }

  template <Executor E>
  void measure_light_trees(E& executor) {
    const auto context = context_for(0, T(0));
    std::vector<LightTreePilot> pilots(pilot_tree_count / chunk_size);
    executor.parallel_for(pilots.size(), [&](std::size_t chunk) {
      Output ignored;
      LightTree tree(context, ignored);
      for (std::size_t i = 0; i < chunk_size; ++i) {
        const auto number = static_cast<std::uint32_t>(chunk * chunk_size + i);
        tree.trace(
            Source(settings_.seed, 0, number, pilot_stream),
            [&](const StoredVertex& vertex, auto&) {
              pilots[chunk].stored += is_worth_storing(vertex) && is_wanted(context, vertex) ? 1 : 0;
            },
            [&](const auto& bsdf, int drawn) {
              if constexpr (Integrator_::Split::splits_light) pilots[chunk].children.count(bsdf, drawn);
            });
      }
    });
    LightTreePilot total;
    for (const LightTreePilot& pilot : pilots) total += pilot;
    vertices_per_tree_ = static_cast<double>(total.stored) / static_cast<double>(pilot_tree_count);
    if constexpr (Integrator_::Split::splits_light) split_.freeze(total.children);
  }

  struct NoPilot {
    NoPilot& operator+=(const NoPilot&) { return *this; }
  };
  template <class Split, bool splits = Split::splits_light>
  struct ChildrenPilot {
    using Type = NoPilot;
  };
  template <class Split>
  struct ChildrenPilot<Split, true> {
    using Type = typename Split::template Pilot<T>;
  };
  struct LightTreePilot {
    std::uint64_t stored = 0;
    [[no_unique_address]] typename ChildrenPilot<typename Integrator_::Split>::Type children;
    LightTreePilot& operator+=(const LightTreePilot& other) {
      stored += other.stored;
      children += other.children;
      return *this;
    }
  };

  [[nodiscard]] static bool is_wanted(const Context& context, const StoredVertex& vertex) noexcept {
    return context.filter.keeps_light(after_scattering(vertex.path, vertex.bsdf));
  }

  [[nodiscard]] Context context_for(std::uint32_t iteration, T radius) const {
    using I = Integrator_;
    const T trees = static_cast<T>(light_tree_count_);
    const T merge_area = trees * pi<T> * radius * radius;
    const bool is_paired = tuning_.connections == paired_connections;
    TechniqueCounts<T> counts;
    counts.emitter_hit = I::template has<EmitterHit> ? T(1) : T(0);
    counts.next_event = I::template has<NextEvent> ? T(1) : T(0);
    // ρ = m n_L / V̄, and the scale of a contribution is V / (m n_L).
    T connection_scale(1);
    if constexpr (I::template has<Connect>) {
      counts.connect = T(1);
      if (!is_paired) {
        const double drawn = static_cast<double>(tuning_.connections);
        counts.connect = vertices_per_tree_ > 0.0 ? static_cast<T>(drawn / vertices_per_tree_) : T(0);
        connection_scale =
            static_cast<T>(static_cast<double>(cache_.size()) / (drawn * static_cast<double>(light_tree_count_)));
      }
    }
    counts.splat = I::template has<Splat> ? trees : T(0);
    counts.merge = I::template has<Merge> ? merge_area : T(0);
    return {scene_,
            typename I::template Recursion<T>(counts),
            split_,
            grid_,
            cache_,
            tuning_.connections,
            connection_scale,
            crop_,
            resolution_,
            settings_.seed,
            iteration,
            settings_.max_depth,
            light_tree_count_,
            merge_area > T(0) ? T(1) / merge_area : T(0),
            typename I::Filter(settings_.path_classes)};
  }

  template <Executor E>
  void trace_light(E& executor, const Context& context) {
    const Stopwatch stopwatch(seconds_.light);
    executor.parallel_for(light_outputs_.size(), [&](std::size_t index) {
      Output& output = light_outputs_[index];
      auto& stored = cache_.chunk(index);
      output.clear();
      stored.clear();
      output.begin_trees(static_cast<std::uint32_t>(index * chunk_size));
      LightTree tree(context, output);
      const std::size_t end = std::min(light_tree_count_, (index + 1) * chunk_size);
      for (std::size_t number = index * chunk_size; number < end; ++number) {
        tree.trace(
            numbers_of(context, PathKind::light, static_cast<std::uint32_t>(number)),
            [&](const StoredVertex& vertex, auto& source) {
              if (!is_worth_storing(vertex)) return;
              if constexpr (Integrator_::stores_light_vertices)
                if (is_wanted(context, vertex)) stored.add(vertex);
              if constexpr (Integrator_::template has<Splat>) Splat::at_light_vertex(context, vertex, source, output);
            },
            [](const auto&, int) {});
        stored.end_tree();
      }
      if constexpr (Integrator_::stores_light_vertices) output.counters.photons_stored += stored.size();
    });
    for (const Output& output : light_outputs_) light_work_ += output.counters;
    for (const Output& output : light_outputs_) counters_ += output.counters;
    if constexpr (Integrator_::stores_light_vertices)
      if (Integrator_::template has<Merge> || tuning_.connections != paired_connections) cache_.gather();
  }

  void build_grid(T radius) {
    const Stopwatch stopwatch(seconds_.grid);
    grid_.build(cache_.size(), radius, [&](std::size_t i) { return cache_[i].point.position; });
    ++counters_.grids_built;
  }

  template <Executor E>
  void trace_camera(E& executor, const Context& context) {
    const Stopwatch stopwatch(seconds_.camera);
    executor.parallel_for(camera_outputs_.size(), [&](std::size_t row) {
      Output& output = camera_outputs_[row];
      output.clear();
      CameraSubpath<Context, Output> subpath(context, output);
      const int y = crop_.lower.y + static_cast<int>(row);
      for (int x = crop_.lower.x; x < crop_.upper.x; ++x) {
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(resolution_.x) + static_cast<std::size_t>(x);
        output.begin_pixel(static_cast<std::uint32_t>(pixel));
        subpath.trace({x, y}, pixel, numbers_of(context, PathKind::camera, static_cast<std::uint32_t>(pixel)));
        frame_[pixel] = output.take_pixel();
      }
    });
    for (const Output& output : camera_outputs_) counters_ += output.counters;
  }

  void add_splats() {
    const Stopwatch stopwatch(seconds_.film);
    for (const Output& output : light_outputs_)
      for (const auto& splat : output.splats()) {
        const S sum = frame_[splat.pixel] + splat.value;
        if (is_finite(sum)) [[likely]]
          frame_[splat.pixel] = sum;
        else
          ++counters_.rejected_non_finite;
      }
  }

  class Stopwatch {
   public:
    explicit Stopwatch(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

   private:
    double& seconds_;
    std::chrono::steady_clock::time_point start_;
  };

  const Sc& scene_;
  RenderSettings settings_;
  glm::ivec2 resolution_;
  PixelBounds crop_;
  Policy split_;
  Tuner<S> tuner_;
  Tuning tuning_;
  double vertices_per_tree_ = 0.0;  ///< V̄ / n_L, from the pilot
  std::size_t light_tree_count_ = 0;
  std::vector<Output> light_outputs_;
  std::vector<Output> camera_outputs_;
  LightVertexCache<StoredVertex> cache_;
  LightVertexGrid<T> grid_;
  std::vector<S> frame_;
  Counters counters_, light_work_;
  RejectionLog rejections_;
  PhaseSeconds seconds_;
  std::uint32_t iteration_ = 0;
  bool is_tuned_ = false;     // no count changes any more
  bool knows_trees_ = false;  // light trees were measured, for `tuning_`
};

}  // namespace gmis
