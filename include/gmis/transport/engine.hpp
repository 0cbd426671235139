#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/check_settings.hpp"
#include "gmis/transport/counts/count_learner.hpp"
#include "gmis/transport/counts/learned_pixel_counts.hpp"
#include "gmis/transport/counts/learned_table.hpp"
#include "gmis/transport/emission/learn_emission.hpp"
#include "gmis/transport/method.hpp"
#include "gmis/transport/photons/pixel_width.hpp"
#include "gmis/transport/settings.hpp"
#include "gmis/transport/walk/camera_subpath.hpp"
#include "gmis/transport/walk/light_tree.hpp"

namespace gmis {

/// Seconds of wall time spent in each phase, measured by the calling thread and summed over iterations.
struct PhaseSeconds {
  double light = 0.0;   ///< tracing light trees
  double grid = 0.0;    ///< building the grid of photons
  double camera = 0.0;  ///< tracing camera subpaths
  double film = 0.0;    ///< adding up

  /// Adds the times of another iteration.
  PhaseSeconds& operator+=(const PhaseSeconds& other) noexcept {
    light += other.light;
    grid += other.grid;
    camera += other.camera;
    film += other.film;
    return *this;
  }
};

/// The engine behind all integrators. An iteration traces the light trees, builds the grid of light vertices and traces
/// one camera subpath per pixel, or more where a `PixelCountTable` says so. `RenderSettings::counts` select the techniques; the engine skips all work that none of
/// them needs.
///
/// Work is divided into chunks of fixed size, which are merged in their order. The same seed therefore gives the same
/// bits for any number of threads. The pixels of a crop have the same bits as in the whole picture, unless numbers of samples are
/// learned.
///
/// The constructor throws `std::invalid_argument` (core/argument_error.hpp) for invalid settings. No other member
/// throws, except when an allocation fails.
template <Scene Sc, class Method_ = BothSides, class Source = SampleNumbers>
class Engine {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Context = IterationContext<Sc, Method_>;
  using StoredVertex = typename Context::StoredVertex;
  using Split = typename Context::Split;
  using Output = typename Method_::template Output<S>;
  /// Light trees take part.
  static constexpr bool has_light_side = Context::has_light_side;

  static_assert(SplitPolicy<Split, typename Sc::Bsdf>);
  static_assert(ChunkOutput<Output, S, typename Context::Recursion::Weight>);

  /// The scene must outlive the engine. `crop` is clipped to the frame; without it the whole frame is rendered.
  Engine(const Sc& scene, const RenderSettings& settings, std::optional<PixelBounds> crop = std::nullopt);

  /// Renders one more iteration; `frame()` is then the image of this iteration alone.
  template <Executor E>
  void iterate(E& executor);

  /// Continues the run of another engine after its iteration `iteration`: random numbers are not reused, and the
  /// merging radius goes on shrinking. Call it before the first iteration.
  void continue_after(std::uint32_t iteration) noexcept { iteration_ = iteration; }

  /// The state for a later run (`core/state_archive.hpp`), between two iterations. What is measured before the first
  /// iteration is measured again, with the same result.
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(iteration_, settings_.counts.radius_factor, merging_gain_, counters_, light_work_, rejections_, seconds_);
    vertex_counts_.exchange_state(archive, frame_.size());
    pixel_counts_.exchange_state(archive, frame_.size());
  }

  /// Guides emission by `guide` from the next iteration on, which learns nothing then. The guide must not depend on samples
  /// of the iterations that it serves. Call it before the first iteration with `RenderSettings::emission` learned.
  void use_emission_guide(EmissionGuide<Sc> guide) {
    has_learned_ = true;
    guide_ = std::move(guide);
  }
  /// Takes the numbers of samples at camera vertices from `table` from the next iteration on; it must have the pixels of the frame
  /// and must not depend on samples of the iterations that it serves. Call it before the first iteration with
  /// `RenderSettings::vertex_counts` learned: nothing is learned then.
  void use_count_table(CountTable<T> table) { vertex_counts_.use(std::move(table), iteration_); }
  /// The table of numbers of samples at camera vertices; null before it is learned, and when it would gain little.
  [[nodiscard]] const CountTable<T>* count_table() const noexcept { return vertex_counts_.table(); }

  /// Traces as many camera subpaths a pixel as `table` says from the next iteration on; it must have the pixels of the frame and must
  /// not depend on samples of the iterations that it serves. Call it before the first iteration with `RenderSettings::pixel_counts`
  /// learned: nothing is learned then.
  void use_pixel_counts(PixelCountTable table) { pixel_counts_.use(std::move(table), iteration_); }
  /// The numbers of camera subpaths; null before they are learned, and when they would gain little.
  [[nodiscard]] const PixelCountTable* pixel_counts() const noexcept { return pixel_counts_.table(); }

  /// The guide of emission, which is learned before the first iteration; null without one.
  [[nodiscard]] const EmissionGuide<Sc>* emission_guide() const noexcept {
    return guide_.is_empty() ? nullptr : &guide_;
  }

  /// True while numbers of samples are learned from the iterations.
  [[nodiscard]] bool is_learning() const noexcept {
    return vertex_counts_.is_learning() || pixel_counts_.is_learning();
  }

  /// Prepares the engine to replay paths of `iteration` (output/replay.hpp): traces the light trees of that iteration.
  /// The engine must not have rendered that iteration or a later one. The same iteration may be prepared again, but no other one.
  template <Executor E>
  void prepare_replay(E& executor, std::uint32_t iteration) {
    while (iteration_ + 1 < iteration && is_learning()) iterate(executor);  // tables come from the iterations before
    iteration_ = iteration - 1;
    begin_iteration(executor);
  }

  /// Sets whether contributions are kept for `for_each_contribution`, from the next iteration on; initially they are
  /// not. They serve for images of single techniques or path classes.
  void keep_contributions(bool keep) noexcept {
    for_each_output([keep](Output& output) { output.keep_contributions(keep); });
  }

  /// Calls `visit(output)` for every chunk of the light side, then of the camera side, in a fixed order.
  template <class Visit>
  void for_each_output(Visit&& visit) {
    for (Output& output : light_outputs_) visit(output);
    for (Output& output : camera_outputs_) visit(output);
  }

  /// Calls `visit(const Contribution<S>&)` for every kept contribution of the latest iteration, in a fixed order.
  template <class Visit>
  void for_each_contribution(Visit&& visit) const {
    for (const auto* outputs : {&light_outputs_, &camera_outputs_})
      for (const Output& output : *outputs)
        for (const auto& record : output.records()) visit(record);
  }

  /// Image of the latest iteration: linear values, rows from the upper left. Pixels outside the crop are black.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  /// For every pixel of the latest iteration, what was merged minus what a disk of half the radius would have merged of the
  /// same photons: mean over channels, rows from the upper left. Empty when merging is off.
  [[nodiscard]] std::span<const float> merging_change() const noexcept { return merging_change_; }
  /// Number of the latest iteration, from 1; 0 before the first one.
  [[nodiscard]] std::uint32_t iteration() const noexcept { return iteration_; }
  /// Counted work of all iterations of this engine.
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }
  /// The part of `counters()` that light trees took.
  [[nodiscard]] const Counters& light_work() const noexcept { return light_work_; }
  /// The first paths with rejections.
  [[nodiscard]] const RejectionLog& rejections() const noexcept { return rejections_; }
  /// Seconds per phase of all iterations of this engine.
  [[nodiscard]] const PhaseSeconds& seconds() const noexcept { return seconds_; }
  /// The counts of every iteration.
  [[nodiscard]] const SampleCounts& counts() const noexcept { return settings_.counts; }
  /// V̄ / n_L: expected number of stored vertices per light tree. It is measured before the first iteration when
  /// weights depend on it; otherwise it is 0.
  [[nodiscard]] double vertices_per_tree() const noexcept { return vertices_per_tree_; }
  /// The rendered part of the frame.
  [[nodiscard]] const PixelBounds& crop() const noexcept { return crop_; }
  /// n_L: number of light trees per iteration; 0 when no technique needs them.
  [[nodiscard]] std::size_t light_tree_count() const noexcept { return light_tree_count_; }

  /// Merging radius of an iteration (from 1) in scene units: r_i = r_1 i^((α−1)/2)
  /// [Hachisuka, Jensen 2009, as Georgiev 2012 eq. 13]; 0 when merging is off.
  [[nodiscard]] double merge_radius(std::uint32_t iteration) const noexcept {
    return first_radius() * std::pow(static_cast<double>(iteration), 0.5 * (settings_.alpha - 1.0));
  }

  /// Merging radius r_1 of the first iteration in scene units; 0 when merging is off.
  [[nodiscard]] double first_radius() const noexcept { return counts().radius_factor * radius_; }

  /// Merges within another radius from the next iteration on: `radius_factor` replaces that of the counts, and the radius goes on
  /// shrinking as if it had been so from the first iteration. It must not depend on samples of the iterations that it serves.
  void merge_within(double radius_factor) noexcept { settings_.counts.radius_factor = radius_factor; }

  /// Multiplies what is merged by 1 + `per_radius` r_i from the next iteration on (`MergingGain`); weights stay as they are. It must
  /// not depend on samples of the iterations that it serves.
  void scale_merging(double per_radius) noexcept { merging_gain_ = per_radius; }
  /// The `per_radius` of the next iteration.
  [[nodiscard]] double merging_gain() const noexcept { return merging_gain_; }
  /// What the latest iteration merged: mean over channels, summed over the pixels of the crop; 0 when merging is off.
  [[nodiscard]] double merged_light() const noexcept {
    double sum = 0.0;
    if constexpr (observes_merges<Output>)
      for (const Output& output : camera_outputs_) sum += output.merged_light();
    return sum;
  }

  /// Number of light vertices that merging gathers in the latest iteration; 0 when merging is off.
  [[nodiscard]] std::size_t photon_count() const noexcept {
    return counts().has(Technique::merge) ? cache_.photons().size() : 0;
  }

  /// Bytes held for light vertices and their grid.
  [[nodiscard]] std::size_t photon_bytes() const noexcept {
    return counts().stores_light_vertices() ? grid_.byte_count() + cache_.byte_count() : 0;
  }

  /// The data that all techniques read in the latest iteration. It holds references into this engine.
  [[nodiscard]] Context context() const { return context_for(iteration_, counts()); }
  /// The source of random numbers for one path of the context's iteration. `subpath`: its number among those of its pixel.
  [[nodiscard]] static Source numbers_of(const Context& context, PathKind kind, std::uint32_t number,
                                         std::uint32_t subpath = 0) {
    const bool is_light = kind == PathKind::light;
    // While numbers of subpaths are learned, all but the first one are independent of it.
    const bool is_independent = subpath > 0 && context.schedule.uniform > 1;
    if constexpr (std::same_as<Source, SampleNumbers>)
      if (context.sampler == Sampler::sobol && !is_independent) [[unlikely]] {
        // Camera subpaths: a sequence a pixel, over the iterations of a replication. Light trees: one sequence over all
        // trees of all these iterations.
        const std::uint32_t replication = (context.iteration - 1) % sobol_replications;
        const std::uint64_t index = (context.iteration - 1) / sobol_replications;
        return is_light ? SampleNumbers::sobol(context.seed, replication, 0, sobol_light_stream,
                                               index * context.tree_count + number, 26)
                        : SampleNumbers::sobol(context.seed, replication, number, sobol_camera_stream,
                                               context.schedule.first_point(number) + subpath, 12);
      }
    const std::uint32_t camera = subpath == 0 ? camera_stream : further_camera_streams + subpath;
    return Source(context.seed, context.iteration, number, is_light ? light_stream : camera);
  }
  /// Calls `trace(pixel, source, share)` for each camera subpath of a pixel (its index in the frame) in the context's iteration. The
  /// pixel is the sum of their values, each multiplied by `share`.
  template <class Trace>
  static void trace_pixel(const Context& context, std::uint32_t pixel, Trace&& trace) {
    const auto width = static_cast<std::uint32_t>(context.resolution.x);
    const glm::ivec2 place(static_cast<int>(pixel % width), static_cast<int>(pixel / width));
    const std::uint32_t count = context.schedule.count(pixel);
    const T share = T(1) / static_cast<T>(count);
    for (std::uint32_t subpath = 0; subpath < count; ++subpath)
      trace(place, numbers_of(context, PathKind::camera, pixel, subpath), share);
  }

 private:
  static constexpr std::size_t chunk_size = 256;
  /// Trees that V̄ is measured with: fewer for a pilot, whose forecasts are less exact than that.
  static constexpr std::size_t census_tree_count = selects_pixels<Output> ? 1024 : 4096;
  enum Stream : std::uint32_t {  // 3: median_pixel_width, 6: learn_emission, 7 and 8: learn_directions
    light_stream = 0,
    camera_stream = 1,
    census_stream = 2,
    sobol_light_stream = 4,
    sobol_camera_stream = 5,
    further_camera_streams = 16  // 17 to 23
  };

  [[nodiscard]] Context context_for(std::uint32_t iteration, const SampleCounts& counts) const;

  /// Starts the next iteration: traces the light trees and builds the grid.
  template <Executor E>
  void begin_iteration(E& executor) {
    if constexpr (has_light_side && GuidableLight<typename Sc::Light>)
      if (settings_.emission == Emission::learned && !has_learned_ && counts().traces_light()) {
        const Stopwatch stopwatch(seconds_.light);
        use_emission_guide(learn_emission(scene_, settings_.seed, settings_.max_depth, executor));
      }
    if constexpr (has_light_side)
      if (!knows_trees_ && counts().traces_light() && (Split::splits_light || counts().draws_connections()))
        measure_light_trees(executor);
    ++iteration_;
    if constexpr (has_light_side) {
      if (counts().traces_light()) trace_light(executor, context());
      if (counts().has(Technique::merge)) build_grid(executor, static_cast<T>(merge_radius(iteration_)));
    }
  }

  /// Measures the mean numbers of vertices and children of a light tree over separate trees, which contribute nothing
  /// to the picture: weights must not depend on the samples that they weight.
  template <Executor E>
  void measure_light_trees(E& executor);
  template <Executor E>
  void trace_light(E& executor, const Context& context);
  template <Executor E>
  void build_grid(E& executor, T radius);
  template <Executor E>
  void trace_camera(E& executor, const Context& context);
  /// Traces the subpaths of a pixel that has more than one, or may have, and notes what they show while their numbers are learned.
  template <class Subpath>
  [[gnu::noinline]] void trace_several(const Context& context, Subpath& subpath, Output& output, std::uint32_t pixel);
  void add_splats();
  /// Learns numbers of samples from the latest iteration, which `work` was done for.
  void learn_counts(const Counters& work);

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
  Split split_;
  double radius_ = 0.0;        // r_1 for a radius factor of 1
  double merging_gain_ = 0.0;  // q of `MergingGain`
  double vertices_per_tree_ = 0.0;
  std::size_t light_tree_count_ = 0;
  std::vector<Output> light_outputs_;
  std::vector<Output> camera_outputs_;
  LightVertexCache<StoredVertex> cache_;
  LightVertexGrid<T> grid_;
  std::vector<S> frame_;
  std::vector<float> merging_change_;
  Counters counters_, light_work_;
  RejectionLog rejections_;
  PhaseSeconds seconds_;
  std::uint32_t iteration_ = 0;
  bool knows_trees_ = false, has_learned_ = false;
  EmissionGuide<Sc> guide_;
  LearnedTable<CountLearner<T>, CountTable<T>> vertex_counts_;
  LearnedPixelCounts pixel_counts_;
};

/// Path tracing: the engine without a light side.
template <Scene Sc, class Source = SampleNumbers>
using PathTracer = Engine<Sc, CameraSide, Source>;

template <Scene Sc, class Method_, class Source>
Engine<Sc, Method_, Source>::Engine(const Sc& scene, const RenderSettings& settings, std::optional<PixelBounds> crop)
    : scene_(scene), settings_(settings), resolution_(scene.camera().resolution()), split_(settings) {
  check_settings<Sc, Method_, Source>(settings, resolution_);
  crop_ = crop.value_or(PixelBounds{{0, 0}, resolution_});
  crop_.lower = glm::max(crop_.lower, glm::ivec2(0));
  crop_.upper = glm::min(crop_.upper, resolution_);
  const auto pixels = static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y);
  frame_.assign(pixels, S(T(0)));
  if (counts().traces_light()) {
    light_tree_count_ =
        static_cast<std::size_t>(std::max(1.0, std::round(counts().light_paths * static_cast<double>(pixels))));
    const std::size_t chunk_count = (light_tree_count_ + chunk_size - 1) / chunk_size;
    light_outputs_.resize(chunk_count);
    cache_.resize(chunk_count, chunk_size);
  }
  if constexpr (observes_merges<Output>)
    if (counts().has(Technique::merge)) merging_change_.assign(pixels, 0.0F);
  if (counts().has(Technique::merge)) radius_ = settings.radius ? *settings.radius : default_radius(scene);
  const glm::ivec2 size = glm::max(crop_.upper - crop_.lower, glm::ivec2(0));
  camera_outputs_.resize(static_cast<std::size_t>(size.y));
  const auto width = static_cast<std::size_t>(resolution_.x);
  const CropPixels crop_pixels{
      width, static_cast<std::size_t>(resolution_.y),
      static_cast<std::size_t>(crop_.lower.y) * width + static_cast<std::size_t>(crop_.lower.x),
      static_cast<std::size_t>(size.x), static_cast<std::size_t>(size.y)};
  if (!counts().traces_camera()) return;
  if (settings.vertex_counts == VertexCounts::learned && counts().camera_children > 0)
    vertex_counts_ = LearnedTable<CountLearner<T>, CountTable<T>>(CountLearner<T>(crop_pixels));
  if (settings.pixel_counts == PixelCounts::learned) pixel_counts_ = LearnedPixelCounts(PixelCountLearner(crop_pixels));
}

template <Scene Sc, class Method_, class Source>
auto Engine<Sc, Method_, Source>::context_for(std::uint32_t iteration, const SampleCounts& counts) const -> Context {
  const T trees = static_cast<T>(light_tree_count_);
  const T radius = iteration > 0 ? static_cast<T>(merge_radius(iteration)) : T(0);
  const T merge_area = trees * pi<T> * radius * radius;
  TechniqueCounts<T> expected;
  expected.emitter_hit = counts.emitter_hits ? T(1) : T(0);
  expected.next_event = counts.next_events ? T(1) : T(0);
  T connection_scale(1);
  if (counts.has(Technique::connect)) {
    expected.connect = T(1);
    if (counts.draws_connections()) {
      // ρ = m n_L / V̄, and the scale of a contribution is V / (m n_L).
      const double drawn = static_cast<double>(counts.connections);
      expected.connect = vertices_per_tree_ > 0.0 ? static_cast<T>(drawn / vertices_per_tree_) : T(0);
      connection_scale =
          static_cast<T>(static_cast<double>(cache_.size()) / (drawn * static_cast<double>(light_tree_count_)));
    }
  }
  expected.splat = counts.has(Technique::splat) ? trees : T(0);
  expected.merge = counts.has(Technique::merge) ? merge_area : T(0);
  expected.merges_first = !counts.local_merges;
  return {
      .scene = scene_,
      .recursion = typename Context::Recursion(expected),
      .split = split_,
      .grid = grid_,
      .cache = cache_,
      .counts = counts,
      .has = {.emitter_hit = counts.has(Technique::emitter_hit),
              .next_event = counts.has(Technique::next_event),
              .connect = counts.has(Technique::connect),
              .splat = counts.has(Technique::splat),
              .merge = counts.has(Technique::merge)},
      .connection_scale = connection_scale,
      .crop = crop_,
      .resolution = resolution_,
      .seed = settings_.seed,
      .sampler = settings_.sampler,
      .iteration = iteration,
      .max_depth = settings_.max_depth,
      .tree_count = light_tree_count_,
      .merge_normalization = merge_area > T(0) ? (T(1) + static_cast<T>(merging_gain_) * radius) / merge_area : T(0),
      .inverse_radius_squared = radius > T(0) ? T(1) / (radius * radius) : T(0),
      .filter = PathFilter(settings_.path_classes),
      .guide = emission_guide(),
      .count_table = count_table(),
      .schedule = schedule_of(pixel_counts_, iteration)};
}

template <Scene Sc, class Method_, class Source>
template <Executor E>
void Engine<Sc, Method_, Source>::iterate(E& executor) {
  const Counters before = counters_;
  begin_iteration(executor);
  if (counts().traces_camera())
    trace_camera(executor, context());
  else
    std::fill(frame_.begin(), frame_.end(), S(T(0)));
  if (counts().has(Technique::splat)) add_splats();
  learn_counts(counters_ - before);
  for_each_output([this](Output& output) { rejections_.append(output.rejections(), iteration_); });
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::learn_counts(const Counters& work) {
  if (!is_learning()) return;
  const Stopwatch stopwatch(seconds_.film);
  const std::span<const S> picture(frame_);
  if (vertex_counts_.is_learning()) vertex_counts_.end_iteration(picture, cost_of(work, vertex_costs), iteration_);
  if (pixel_counts_.is_learning()) pixel_counts_.end_iteration(picture, cost_of(work), iteration_);
}

template <Scene Sc, class Method_, class Source>
template <Executor E>
void Engine<Sc, Method_, Source>::measure_light_trees(E& executor) {
  struct Census {
    std::uint64_t stored = 0;
    typename detail::TallyOf<Split>::Type children{};
  };
  SampleCounts counts = this->counts();
  counts.splats = false;
  const Context context = context_for(0, counts);
  std::vector<Census> parts(census_tree_count / chunk_size);
  executor.parallel_for(parts.size(), [&](std::size_t part) {
    Output ignored;
    typename LightVertexCache<StoredVertex>::Chunk stored;
    LightTree<Context, Output> tree(context, ignored);
    for (std::size_t i = 0; i < chunk_size; ++i)
      tree.trace(Source(settings_.seed, 0, static_cast<std::uint32_t>(part * chunk_size + i), census_stream), &stored,
                 [&](const auto& bsdf, int drawn) { parts[part].children.count(bsdf, drawn); });
    parts[part].stored = stored.size();
  });
  Census whole;
  for (const Census& part : parts) {
    whole.stored += part.stored;
    whole.children += part.children;
  }
  vertices_per_tree_ = static_cast<double>(whole.stored) / static_cast<double>(census_tree_count);
  if constexpr (Split::splits_light) split_.freeze(whole.children);
  knows_trees_ = true;
}

template <Scene Sc, class Method_, class Source>
template <Executor E>
void Engine<Sc, Method_, Source>::trace_light(E& executor, const Context& context) {
  const Stopwatch stopwatch(seconds_.light);
  const bool stores = counts().stores_light_vertices();
  executor.parallel_for(light_outputs_.size(), [&](std::size_t index) {
    Output& output = light_outputs_[index];
    auto& chunk = cache_.chunk(index);
    output.clear();
    chunk.clear();
    output.begin_trees(static_cast<std::uint32_t>(index * chunk_size));
    LightTree<Context, Output> tree(context, output);
    const std::size_t end = std::min(light_tree_count_, (index + 1) * chunk_size);
    for (std::size_t number = index * chunk_size; number < end; ++number) {
      tree.trace(numbers_of(context, PathKind::light, static_cast<std::uint32_t>(number)), stores ? &chunk : nullptr);
      chunk.end_tree();
    }
    if (stores) output.counters().photons_stored += chunk.size();
  });
  for (const Output& output : light_outputs_) light_work_ += output.counters();
  for (const Output& output : light_outputs_) counters_ += output.counters();
  if (counts().has(Technique::merge) || counts().draws_connections()) cache_.gather(executor);
}

template <Scene Sc, class Method_, class Source>
template <Executor E>
void Engine<Sc, Method_, Source>::build_grid(E& executor, T radius) {
  const Stopwatch stopwatch(seconds_.grid);
  const std::span<const std::uint32_t> photons = cache_.photons();
  grid_.build(
      executor, photons.size(), radius, [&](std::size_t i) { return cache_[photons[i]].point.position; },
      [&](std::size_t i) { return photons[i]; });
  ++counters_.grids_built;
}

template <Scene Sc, class Method_, class Source>
template <Executor E>
void Engine<Sc, Method_, Source>::trace_camera(E& executor, const Context& context) {
  const Stopwatch stopwatch(seconds_.camera);
  const bool has_one_subpath = context.schedule.table == nullptr && context.schedule.uniform == 1;
  executor.parallel_for(camera_outputs_.size(), [&](std::size_t row) {
    Output& output = camera_outputs_[row];
    output.clear();
    CameraSubpath<Context, Output> subpath(context, output);
    VertexLog<T>* const log = vertex_counts_.is_learning() ? &vertex_counts_.learner().log(row) : nullptr;
    if (log != nullptr) log->clear();
    const int y = crop_.lower.y + static_cast<int>(row);
    for (int x = crop_.lower.x; x < crop_.upper.x; ++x) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(resolution_.x) + static_cast<std::size_t>(x);
      if constexpr (selects_pixels<Output>)
        if (!output.takes(static_cast<std::uint32_t>(pixel))) {
          frame_[pixel] = S(T(0));
          continue;
        }
      output.begin_pixel(static_cast<std::uint32_t>(pixel));
      if (log != nullptr) subpath.log_to(vertex_counts_.learner().is_logged(pixel) ? log : nullptr);
      if (has_one_subpath) [[likely]]
        subpath.trace({x, y}, pixel, numbers_of(context, PathKind::camera, static_cast<std::uint32_t>(pixel)));
      else
        trace_several(context, subpath, output, static_cast<std::uint32_t>(pixel));
      frame_[pixel] = output.take_pixel();
      if constexpr (observes_merges<Output>)
        if (!merging_change_.empty()) merging_change_[pixel] = output.merging_change();
    }
  });
  for (const Output& output : camera_outputs_) counters_ += output.counters();
}

template <Scene Sc, class Method_, class Source>
template <class Subpath>
void Engine<Sc, Method_, Source>::trace_several(const Context& context, Subpath& subpath, Output& output,
                                                std::uint32_t pixel) {
  const double cost_before = cost_of(output.counters());
  T but_last(0);
  trace_pixel(context, pixel, [&](glm::ivec2 place, const Source& numbers, T share) {
    but_last = mean_channel(output.take_pixel());
    subpath.trace(place, pixel, numbers, share);
  });
  if (pixel_counts_.is_learning())
    pixel_counts_.learner().note(pixel, 2.0 * static_cast<double>(mean_channel(output.take_pixel()) - T(2) * but_last),
                                 cost_of(output.counters()) - cost_before);
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::add_splats() {
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

}  // namespace gmis
