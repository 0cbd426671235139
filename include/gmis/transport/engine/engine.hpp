#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/emission/learn_lights.hpp"
#include "gmis/transport/engine/any_engine.hpp"
#include "gmis/transport/engine/method.hpp"
#include "gmis/transport/engine/validation.hpp"
#include "gmis/transport/photons/pixel_width.hpp"
#include "gmis/transport/walk/camera_subpath.hpp"

namespace gmis {

namespace detail {

/// Adds the wall time of its lifetime to a sum.
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

}  // namespace detail

/// The engine behind all integrators. An iteration traces the light trees, builds the grid of light
/// vertices and traces one camera subpath per pixel. `RenderSettings::counts` select the
/// techniques; the engine skips all work that none of them needs.
///
/// Work is divided into chunks of fixed size, which are merged in their order. The same seed
/// therefore gives the same bits for any number of threads. The pixels of a crop have the same bits
/// as in the whole picture.
///
/// The constructor throws `std::invalid_argument` (core/argument_error.hpp) for invalid settings.
/// No other member throws, except when an allocation fails.
template <Scene Sc, class Method_ = BothSides, class Source = SampleNumbers>
class Engine : public AnyEngine<typename Sc::Spectrum> {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using Context = IterationContext<Sc, Method_>;
  using StoredVertex = typename Context::StoredVertex;
  using Split = typename Context::Split;
  using Output = typename Method_::template Output<S>;
  /// Traces light subpaths or light trees.
  using LightWalk = typename Method_::template LightWalk<Context, Output>;
  /// Light trees take part.
  static constexpr bool has_light_side = Context::has_light_side;

  static_assert(SplitPolicy<Split, typename Sc::Bsdf>);
  static_assert(ChunkOutput<Output, S, typename Context::Recursion::Weight>);

  /// The scene must outlive the engine. `crop` is clipped to the frame; without it the whole frame
  /// is rendered. `split` holds the settings of a method whose light trees split (`GmisSampler`).
  GMIS_RARE Engine(const Sc& scene, const RenderSettings& settings,
                   const std::optional<PixelBounds>& crop = std::nullopt, const typename Split::Settings& split = {});

  GMIS_RARE ~Engine() override;

  GMIS_RARE void iterate(ExecutorRef executor) override;

  /// The guide of emission, which is learned before the first iteration; null without one.
  [[nodiscard]] const EmissionGuide<Sc>* emission_guide() const noexcept {
    return lights_ == nullptr || lights_->guide.is_empty() ? nullptr : &lights_->guide;
  }
  GMIS_RARE void learn_lights(std::uint64_t seed, ExecutorRef executor) override {
    if constexpr (GuidableLight<typename Sc::Light>) {
      const bool guides = settings_.emission == Emission::learned && this->counts().traces_light();
      if (lights_ != nullptr || !(guides || receiver_choice_of(scene_) == ReceiverChoice::where_it_pays)) return;
      const detail::Stopwatch stopwatch(seconds_.light);
      lights_ = gmis::learn_lights(scene_, seed, settings_.max_depth, executor, guides ? most_relative_moment : 0.0);
    }
  }
  [[nodiscard]] std::shared_ptr<const AnyLearnedLights> learned_lights() const noexcept override { return lights_; }
  void use_lights(std::shared_ptr<const AnyLearnedLights> lights) override {
    lights_ = std::static_pointer_cast<const LearnedLights<Sc>>(std::move(lights));
  }
  [[nodiscard]] LightUse light_use() const noexcept override {
    LightUse use;
    use.chooses_for_receiver = chooses_for_receiver();
    use.guides_emission = emission_guide() != nullptr && this->counts().traces_light();
    if (lights_ == nullptr) return use;
    if (receiver_choice_of(scene_) == ReceiverChoice::where_it_pays) use.receiver_gain = lights_->receiver_gain;
    use.emission_gain = lights_->emission_gain;
    return use;
  }
  /// True when next events choose lights for the receiver.
  [[nodiscard]] bool chooses_for_receiver() const noexcept {
    const ReceiverChoice choice = receiver_choice_of(scene_);
    return choice == ReceiverChoice::always ||
           (choice == ReceiverChoice::where_it_pays && lights_ != nullptr && lights_->choose_for_receiver());
  }

  /// Prepares the engine to replay paths of `iteration` (replay/replay.hpp): traces the light trees
  /// of that iteration. The engine must not have rendered that iteration or a later one. The same
  /// iteration may be prepared again, but no other one.
  GMIS_RARE void prepare_replay(ExecutorRef executor, std::uint32_t iteration);

  GMIS_RARE void keep_contributions(bool keep) override {
    if constexpr (requires(Output & output) { output.keep_contributions(keep); })
      for_each_output([keep](Output& output) { output.keep_contributions(keep); });
  }
  /// Calls `visit` for every kept contribution, the light side first, in the order of the chunks.
  GMIS_RARE void for_each_contribution(const std::function<void(const Contribution<S>&)>& visit) const override {
    for (const auto* outputs : {&light_outputs_, &camera_outputs_})
      for (const Output& output : *outputs)
        if constexpr (requires { output.records(); })
          for (const auto& record : output.records()) visit(record);
  }
  /// Calls `visit(output)` for every chunk of the light side, then of the camera side, in a fixed
  /// order.
  template <class Visit>
  void for_each_output(Visit&& visit) {
    for (Output& output : light_outputs_) visit(output);
    for (Output& output : camera_outputs_) visit(output);
  }

  /// Number of light vertices that merging gathers in the latest iteration; 0 when merging is off.
  [[nodiscard]] std::size_t photon_count() const noexcept {
    return this->counts().has(Technique::merge) ? cache_.photons().size() : 0;
  }
  GMIS_RARE [[nodiscard]] std::size_t photon_bytes() const noexcept override {
    if constexpr (has_light_side)
      if (this->counts().stores_light_vertices()) return grid_.byte_count() + cache_.byte_count();
    return 0;
  }

  /// The data that all techniques read in the latest iteration. It holds references into this
  /// engine.
  [[nodiscard]] Context context() const { return context_for(iteration_, this->counts()); }
  /// The source of random numbers for one path of the context's iteration: the camera subpath of
  /// the pixel `number` (its index in the frame), or the light tree `number`.
  [[nodiscard]] static Source numbers_of(const Context& context, PathKind kind, std::uint32_t number) {
    const bool is_light = kind == PathKind::light;
    if constexpr (std::same_as<Source, SampleNumbers>)
      if (context.keys.sampler == Sampler::sobol) [[unlikely]] {
        // Camera subpaths: a sequence a pixel, over the iterations of a replication. Light trees:
        // one sequence over all trees of all these iterations.
        const std::uint32_t replication = (context.keys.iteration - 1) % sobol_replications;
        const std::uint64_t index = (context.keys.iteration - 1) / sobol_replications;
        return is_light ? SampleNumbers::sobol(context.keys.seed, replication, 0, sobol_light_stream,
                                               index * context.light.tree_count + number, 26)
                        : SampleNumbers::sobol(context.keys.seed, replication, number, sobol_camera_stream, index, 12);
      }
    return Source(context.keys.seed, context.keys.iteration, number, is_light ? light_stream : camera_stream);
  }

 private:
  using Base = AnyEngine<S>;
  using Base::iteration_, Base::settings_, Base::counters_, Base::seconds_, Base::frame_, Base::light_tree_count_;

  static constexpr std::size_t chunk_size = 256;
  /// Trees that V̄ is measured with: fewer for a pilot, whose forecasts are less exact than that.
  static constexpr std::size_t census_tree_count =
      detail::is_hot_walk<Context, Output> || Split::is_measured ? 4096 : 1024;
  enum Stream : std::uint32_t {  // 3: median_pixel_width, 6: learn_lights, 7: check_scene and programs, 8: programs
    light_stream = 0,
    camera_stream = 1,
    census_stream = 2,
    sobol_light_stream = 4,
    sobol_camera_stream = 5
  };

  GMIS_RARE [[nodiscard]] Context context_for(std::uint32_t iteration, const SampleCounts& counts) const;
  /// The counts of the weights, κ and μ, in an iteration with this area of all merging disks, n_L π
  /// r².
  GMIS_RARE [[nodiscard]] TechniqueCounts<T> nominal_counts(const SampleCounts& counts, T merge_area) const;

  /// Starts the next iteration: traces the light trees and builds the grid.
  GMIS_RARE void begin_iteration(ExecutorRef executor);
  /// Measures the mean numbers of vertices and children of a light tree over separate trees, which
  /// contribute nothing to the picture: weights must not depend on the samples that they weight.
  GMIS_RARE void measure_light_trees(ExecutorRef executor);
  void trace_light(ExecutorRef executor, const Context& context);
  void build_grid(ExecutorRef executor, T radius);
  void trace_camera(ExecutorRef executor, const Context& context);
  void add_splats();

  const Sc& scene_;
  Split split_;
  std::vector<Output> light_outputs_;
  std::vector<Output> camera_outputs_;
  LightVertexCache<StoredVertex> cache_;
  LightVertexGrid<T> grid_;
  bool knows_trees_ = false;
  std::shared_ptr<const LearnedLights<Sc>> lights_;
};

/// Path tracing: the engine without a light side.
template <Scene Sc, class Source = SampleNumbers>
using PathTracer = Engine<Sc, CameraSide, Source>;

template <Scene Sc, class Method_, class Source>
Engine<Sc, Method_, Source>::Engine(const Sc& scene, const RenderSettings& settings,
                                    const std::optional<PixelBounds>& crop, const typename Split::Settings& split)
    : Base(validated<Sc, Method_, Source>(settings, scene.camera().resolution(), split), scene.camera().resolution(),
           crop),
      scene_(scene),
      split_(split) {
  if constexpr (has_light_side) {
    const std::size_t chunk_count = (light_tree_count_ + chunk_size - 1) / chunk_size;
    light_outputs_.resize(chunk_count);
    cache_.resize(chunk_count, chunk_size);
  }
  if (this->counts().has(Technique::merge)) this->radius_ = settings.radius ? *settings.radius : default_radius(scene);
  camera_outputs_.resize(static_cast<std::size_t>(std::max(0, this->crop_.upper.y - this->crop_.lower.y)));
}

template <Scene Sc, class Method_, class Source>
TechniqueCounts<ScalarOf<typename Sc::Spectrum>> Engine<Sc, Method_, Source>::nominal_counts(const SampleCounts& counts,
                                                                                             T merge_area) const {
  TechniqueCounts<T> nominal;
  nominal.emitter_hit = counts.emitter_hits ? T(1) : T(0);
  nominal.next_event = counts.next_events ? T(1) : T(0);
  if (counts.has(Technique::connect)) {
    nominal.connect = T(1);
    if (counts.draws_connections()) {  // ρ = m n_L / V̄
      const double drawn = static_cast<double>(counts.connections);
      const double least = 1.0 / static_cast<double>(census_tree_count);
      nominal.connect = knows_trees_ ? static_cast<T>(drawn / std::max(this->vertices_per_tree_, least)) : T(0);
    }
  }
  nominal.splat = counts.has(Technique::splat) ? static_cast<T>(light_tree_count_) : T(0);
  nominal.merge = counts.has(Technique::merge) ? merge_area : T(0);
  nominal.merges_first = !counts.local_merges;
  return nominal;
}

template <Scene Sc, class Method_, class Source>
Engine<Sc, Method_, Source>::~Engine() = default;

template <Scene Sc, class Method_, class Source>
auto Engine<Sc, Method_, Source>::context_for(std::uint32_t iteration, const SampleCounts& counts) const -> Context {
  const T radius = iteration > 0 ? static_cast<T>(this->merge_radius(iteration)) : T(0);
  const T merge_area = static_cast<T>(light_tree_count_) * pi<T> * radius * radius;
  T connection_scale(1);
  if (counts.draws_connections())  // V / (m n_L)
    connection_scale = static_cast<T>(static_cast<double>(cache_.size()) / (static_cast<double>(counts.connections) *
                                                                            static_cast<double>(light_tree_count_)));
  const T gain = T(1) + static_cast<T>(this->merging_gain_) * radius;
  return {.scene = scene_,
          .recursion = typename Context::Recursion(nominal_counts(counts, merge_area)),
          .split = split_,
          .counts = counts,
          .has = {.emitter_hit = counts.has(Technique::emitter_hit),
                  .next_event = counts.has(Technique::next_event),
                  .connect = counts.has(Technique::connect),
                  .splat = counts.has(Technique::splat),
                  .merge = counts.has(Technique::merge)},
          .max_depth = settings_.max_depth,
          .frame = {this->crop_, this->resolution_},
          .keys = {.seed = settings_.seed, .sampler = settings_.sampler, .iteration = iteration},
          .filter = PathFilter(settings_.path_classes),
          .light = {.cache = cache_, .tree_count = light_tree_count_, .connection_scale = connection_scale},
          .photons = {.grid = grid_,
                      .normalization = merge_area > T(0) ? gain / merge_area : T(0),
                      .inverse_radius_squared = radius > T(0) ? T(1) / (radius * radius) : T(0)},
          .guide = emission_guide(),
          .chooses_for_receiver = chooses_for_receiver()};
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::begin_iteration(ExecutorRef executor) {
  learn_lights(settings_.seed, executor);
  if constexpr (has_light_side)
    if (!knows_trees_ && this->counts().traces_light() && (Split::is_measured || this->counts().draws_connections()))
      measure_light_trees(executor);
  ++iteration_;
  if constexpr (has_light_side) {
    if (this->counts().traces_light()) trace_light(executor, context());
    if (this->counts().has(Technique::merge)) build_grid(executor, static_cast<T>(this->radius()));
  }
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::iterate(ExecutorRef executor) {
  begin_iteration(executor);
  if (this->counts().traces_camera())
    trace_camera(executor, context());
  else
    std::fill(frame_.begin(), frame_.end(), S(T(0)));
  if constexpr (has_light_side)
    if (this->counts().has(Technique::splat)) add_splats();
  for_each_output([this](Output& output) { this->rejections_.append(output.rejections(), iteration_); });
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::prepare_replay(ExecutorRef executor, std::uint32_t iteration) {
  iteration_ = iteration - 1;
  begin_iteration(executor);
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::measure_light_trees(ExecutorRef executor) {
  struct Census {
    std::uint64_t stored = 0;
    typename Split::Tally children{};
  };
  SampleCounts counts = this->counts();
  counts.splats = false;
  const Context context = context_for(0, counts);
  std::vector<Census> parts(census_tree_count / chunk_size);
  executor.parallel_for(parts.size(), [&](std::size_t part) {
    Output ignored;
    if constexpr (has_light_side) {
      LightWalk tree(context, ignored);
      for (std::size_t i = 0; i < chunk_size; ++i) {
        typename LightVertexCache<StoredVertex>::Chunk stored;
        tree.trace(Source(settings_.seed, 0, static_cast<std::uint32_t>(part * chunk_size + i), census_stream), &stored,
                   &parts[part].children);
        parts[part].stored += stored.size();
      }
    }
  });
  Census whole;
  for (const Census& part : parts) {
    whole.stored += part.stored;
    whole.children += part.children;
  }
  this->vertices_per_tree_ = static_cast<double>(whole.stored) / static_cast<double>(census_tree_count);
  split_.freeze(whole.children);
  knows_trees_ = true;
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::trace_light(ExecutorRef executor, const Context& context) {
  const detail::Stopwatch stopwatch(seconds_.light);
  const bool stores = this->counts().stores_light_vertices();
  executor.parallel_for(light_outputs_.size(), [&](std::size_t index) {
    Output& output = light_outputs_[index];
    auto& chunk = cache_.chunk(index);
    output.clear();
    chunk.clear();
    output.begin_trees(static_cast<std::uint32_t>(index * chunk_size));
    if constexpr (has_light_side) {
      LightWalk tree(context, output);
      const std::size_t end = std::min(light_tree_count_, (index + 1) * chunk_size);
      for (std::size_t number = index * chunk_size; number < end; ++number) {
        tree.trace(numbers_of(context, PathKind::light, static_cast<std::uint32_t>(number)), stores ? &chunk : nullptr);
        chunk.end_tree();
      }
    }
    if (stores) output.counters().photons_stored += chunk.size();
  });
  for (const Output& output : light_outputs_) this->light_work_ += output.counters();
  for (const Output& output : light_outputs_) counters_ += output.counters();
  if (this->counts().has(Technique::merge) || this->counts().draws_connections()) cache_.gather(executor);
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::build_grid(ExecutorRef executor, T radius) {
  const detail::Stopwatch stopwatch(seconds_.grid);
  const std::span<const std::uint32_t> photons = cache_.photons();
  grid_.build(
      executor, photons.size(), radius, [&](std::size_t i) { return cache_[photons[i]].point.position; },
      [&](std::size_t i) { return photons[i]; });
  ++counters_.grids_built;
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::trace_camera(ExecutorRef executor, const Context& context) {
  const detail::Stopwatch stopwatch(seconds_.camera);
  executor.parallel_for(camera_outputs_.size(), [&](std::size_t row) {
    Output& output = camera_outputs_[row];
    output.clear();
    CameraSubpath<Context, Output> subpath(context, output);
    const int y = this->crop_.lower.y + static_cast<int>(row);
    for (int x = this->crop_.lower.x; x < this->crop_.upper.x; ++x) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(this->resolution_.x) + static_cast<std::size_t>(x);
      if (!output.takes(static_cast<std::uint32_t>(pixel))) {
        frame_[pixel] = S(T(0));
        continue;
      }
      output.begin_pixel(static_cast<std::uint32_t>(pixel));
      subpath.trace({x, y}, pixel, numbers_of(context, PathKind::camera, static_cast<std::uint32_t>(pixel)));
      frame_[pixel] = output.take_pixel();
      if (!this->merging_change_.empty()) this->merging_change_[pixel] = output.merging_change();
    }
  });
  this->merged_light_ = 0.0;
  for (const Output& output : camera_outputs_) {
    counters_ += output.counters();
    this->merged_light_ += output.merged_light();
  }
}

template <Scene Sc, class Method_, class Source>
void Engine<Sc, Method_, Source>::add_splats() {
  const detail::Stopwatch stopwatch(seconds_.film);
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
