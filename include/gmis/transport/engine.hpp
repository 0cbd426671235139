#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gmis/transport/contribution.hpp"
#include "gmis/transport/light_subpaths.hpp"
#include "gmis/transport/light_vertex_grid.hpp"
#include "gmis/transport/settings.hpp"
#include "gmis/transport/split.hpp"
#include "gmis/transport/technique_list.hpp"
#include "gmis/transport/techniques/connect.hpp"
#include "gmis/transport/techniques/emitter_hit.hpp"
#include "gmis/transport/techniques/merge.hpp"
#include "gmis/transport/techniques/next_event.hpp"
#include "gmis/transport/techniques/splat.hpp"
#include "gmis/transport/vertex.hpp"

namespace gmis {

/// A way to render: which techniques, how light trees split, by which heuristic they are weighted.
template <class TechniqueList_, class Split_ = NoSplit, class Heuristic_ = BalanceRatio>
struct Integrator {
  using TechniqueList = TechniqueList_;
  using Split = Split_;
  using Heuristic = Heuristic_;
  template <class T>
  static constexpr bool has = TechniqueList::template contains<T>;
  static constexpr bool stores_light_vertices = has<Connect> || has<Merge>;
  static constexpr bool traces_light = stores_light_vertices || has<Splat>;
};

/// A rectangle of pixels, the upper ends excluded.
struct PixelBounds {
  glm::ivec2 lower{0, 0};
  glm::ivec2 upper{0, 0};
};

/// Seconds spent in each phase, summed over iterations, as seen by the calling thread.
struct PhaseSeconds {
  double light = 0.0;
  double grid = 0.0;
  double camera = 0.0;
  double film = 0.0;
};

/// Everything that is fixed during one iteration and read by all techniques.
template <Scene Sc, class Integrator_>
struct IterationContext {
  using SceneType = Sc;
  using IntegratorType = Integrator_;
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;
  using StoredVertex = LightVertex<Sc>;

  const Sc& scene;
  WeightRecursion<T, typename Integrator_::Heuristic> recursion;
  typename Integrator_::Split::template Policy<T> split;
  const LightVertexGrid<T>& grid;
  std::span<const StoredVertex* const> vertices;  ///< all light vertices, in the order of the grid's indices
  PixelBounds crop;
  glm::ivec2 resolution;
  std::uint64_t seed;
  std::uint32_t iteration;
  int max_depth;
  T light_tree_count;
  T merge_normalization;  ///< 1 / (n_L π r²)

  [[nodiscard]] const StoredVertex& stored_vertex(std::uint32_t index) const noexcept { return *vertices[index]; }

  /// The pixel's place in the frame, or −1 when it is outside what is rendered.
  [[nodiscard]] std::int64_t pixel_index(glm::ivec2 pixel) const noexcept {
    if (pixel.x < crop.lower.x || pixel.y < crop.lower.y || pixel.x >= crop.upper.x || pixel.y >= crop.upper.y)
      return -1;
    return static_cast<std::int64_t>(pixel.y) * resolution.x + pixel.x;
  }
};

/// The one engine behind all integrators: an iteration traces the light trees, builds the grid, then traces one camera
/// subpath a pixel; whatever the integrator's techniques do not need is not compiled in. Work is cut into chunks of
/// fixed size and merged in their order, so that the same seed gives the same bits for any number of threads.
///
/// `records_techniques` keeps every contribution of the latest iteration with the technique that made it
/// (`for_each_contribution`), for images of single techniques.
template <Scene Sc, class Integrator_, bool records_techniques = false, class Source = Philox>
class Engine {
 public:
  using S = typename Sc::Spectrum;
  using T = ScalarOf<S>;

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
      light_chunks_.resize((light_tree_count_ + chunk_size - 1) / chunk_size);
    }
    const auto rows = static_cast<std::size_t>(std::max(0, crop_.upper.y - crop_.lower.y));
    camera_chunks_.resize(rows);
    split_ = typename Integrator_::Split::template Policy<T>(settings);
  }

  /// Measures what must be known before the first iteration and is frozen for all: the mean numbers of children, from
  /// light trees whose random numbers are used for nothing else. Called by the first `iterate` if not before.
  template <Executor E>
  void prepare(E& executor) {
    if (is_prepared_) return;
    is_prepared_ = true;
    if constexpr (Integrator_::traces_light && Integrator_::Split::splits) {
      using Pilot = typename Integrator_::Split::template Pilot<T>;
      const auto context = context_for(0, T(0));
      std::vector<Pilot> pilots(pilot_tree_count / chunk_size);
      executor.parallel_for(pilots.size(), [&](std::size_t chunk) {
        Counters ignored;
        LightTree tree(context, ignored);
        for (std::size_t i = 0; i < chunk_size; ++i) {
          const auto number = static_cast<std::uint32_t>(chunk * chunk_size + i);
          tree.trace(
              Source(settings_.seed, 0, number, pilot_stream), [](const auto&, auto&) {},
              [&](const auto& bsdf, int drawn) { pilots[chunk].count(bsdf, drawn); });
        }
      });
      Pilot total;
      for (const Pilot& pilot : pilots) total += pilot;
      split_.freeze(total);
    }
  }

  /// Renders one more iteration; the image it alone gives is `frame()` afterwards.
  template <Executor E>
  void iterate(E& executor) {
    prepare(executor);
    ++iteration_;
    const T radius = static_cast<T>(merge_radius(iteration_));
    if constexpr (Integrator_::traces_light) {
      trace_light(executor, context_for(iteration_, radius));
      if constexpr (Integrator_::template has<Merge>) build_grid(radius);
    }
    trace_camera(executor, context_for(iteration_, radius));
    if constexpr (Integrator_::template has<Splat>) add_splats();
  }

  /// Linear values by rows from the upper left; pixels outside the crop stay black.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  [[nodiscard]] std::uint32_t iteration() const noexcept { return iteration_; }
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }
  [[nodiscard]] const PhaseSeconds& seconds() const noexcept { return seconds_; }
  [[nodiscard]] const auto& split() const noexcept { return split_; }

  /// r_i = r_1 i^((α−1)/2) [Hachisuka, Jensen 2009, as Georgiev 2012 eq. 13].
  [[nodiscard]] double merge_radius(std::uint32_t iteration) const noexcept {
    return settings_.radius * std::pow(static_cast<double>(iteration), 0.5 * (settings_.alpha - 1.0));
  }

  /// Bytes held for light vertices and their grid.
  [[nodiscard]] std::size_t photon_bytes() const noexcept {
    std::size_t bytes = grid_.byte_count() + vertices_.capacity() * sizeof(vertices_[0]);
    for (const LightChunk& chunk : light_chunks_)
      bytes += chunk.vertices.capacity() * sizeof(LightVertex<Sc>) + chunk.tree_ends.capacity() * sizeof(std::uint32_t);
    return bytes;
  }

  /// Calls `visit(const Contribution<S>&)` for every contribution of the latest iteration, in a fixed order.
  template <class Visit>
  void for_each_contribution(Visit&& visit) const {
    static_assert(records_techniques, "this engine does not record techniques");
    for (const LightChunk& chunk : light_chunks_)
      for (const auto& record : chunk.output.records()) visit(record);
    for (const Output& output : camera_chunks_)
      for (const auto& record : output.records()) visit(record);
  }

 private:
  static constexpr std::size_t chunk_size = 256;
  static constexpr std::size_t pilot_tree_count = 4096;
  enum Stream : std::uint32_t { light_stream = 0, camera_stream = 1, pilot_stream = 2 };

  using Context = IterationContext<Sc, Integrator_>;
  using Output = ChunkOutput<S, records_techniques>;
  using LightTree = gmis::LightTree<Context>;

  struct LightChunk {
    Output output;
    std::vector<LightVertex<Sc>> vertices;
    std::vector<std::uint32_t> tree_ends;
  };

  [[nodiscard]] Context context_for(std::uint32_t iteration, T radius) const {
    using I = Integrator_;
    const T trees = static_cast<T>(light_tree_count_);
    const T merge_area = trees * pi<T> * radius * radius;
    TechniqueCounts<T> counts;
    counts.emitter_hit = I::template has<EmitterHit> ? T(1) : T(0);
    counts.next_event = I::template has<NextEvent> ? T(1) : T(0);
    counts.connect = I::template has<Connect> ? T(1) : T(0);
    counts.splat = I::template has<Splat> ? trees : T(0);
    counts.merge = I::template has<Merge> ? merge_area : T(0);
    return {scene_,      WeightRecursion<T, typename I::Heuristic>(counts),
            split_,      grid_,
            vertices_,   crop_,
            resolution_, settings_.seed,
            iteration,   settings_.max_depth,
            trees,       merge_area > T(0) ? T(1) / merge_area : T(0)};
  }

  template <Executor E>
  void trace_light(E& executor, const Context& context) {
    const Stopwatch stopwatch(seconds_.light);
    executor.parallel_for(light_chunks_.size(), [&](std::size_t index) {
      LightChunk& chunk = light_chunks_[index];
      chunk.output.clear();
      chunk.vertices.clear();
      chunk.tree_ends.clear();
      LightTree tree(context, chunk.output.counters);
      const std::size_t end = std::min(light_tree_count_, (index + 1) * chunk_size);
      for (std::size_t number = index * chunk_size; number < end; ++number) {
        tree.trace(
            Source(settings_.seed, context.iteration, static_cast<std::uint32_t>(number), light_stream),
            [&](const LightVertex<Sc>& vertex, auto& source) {
              if (vertex.bsdf.is_purely_delta()) return;
              if constexpr (Integrator_::stores_light_vertices) chunk.vertices.push_back(vertex);
              if constexpr (Integrator_::template has<Splat>)
                Splat::at_light_vertex(context, vertex, source, chunk.output);
            },
            [](const auto&, int) {});
        chunk.tree_ends.push_back(static_cast<std::uint32_t>(chunk.vertices.size()));
      }
    });
    for (const LightChunk& chunk : light_chunks_) {
      counters_ += chunk.output.counters;
      counters_.photons_stored += chunk.vertices.size();
    }
  }

  void build_grid(T radius) {
    const Stopwatch stopwatch(seconds_.grid);
    vertices_.clear();
    for (const LightChunk& chunk : light_chunks_)
      for (const LightVertex<Sc>& vertex : chunk.vertices) vertices_.push_back(&vertex);
    grid_.build(vertices_.size(), radius, [&](std::size_t i) { return vertices_[i]->point.position; });
    ++counters_.grids_built;
  }

  /// The vertices of the tree that the camera subpath of a pixel is paired with.
  [[nodiscard]] std::span<const LightVertex<Sc>> paired_tree(std::size_t pixel) const noexcept {
    const std::size_t tree =
        frame_.size() == light_tree_count_
            ? pixel
            : static_cast<std::size_t>(static_cast<std::uint64_t>(pixel) * light_tree_count_ / frame_.size());
    const LightChunk& chunk = light_chunks_[tree / chunk_size];
    const std::size_t local = tree % chunk_size;
    const std::size_t begin = local == 0 ? 0 : chunk.tree_ends[local - 1];
    return {chunk.vertices.data() + begin, chunk.tree_ends[local] - begin};
  }

  template <Executor E>
  void trace_camera(E& executor, const Context& context) {
    const Stopwatch stopwatch(seconds_.camera);
    executor.parallel_for(camera_chunks_.size(), [&](std::size_t row) {
      Output& output = camera_chunks_[row];
      output.clear();
      const int y = crop_.lower.y + static_cast<int>(row);
      for (int x = crop_.lower.x; x < crop_.upper.x; ++x) {
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(resolution_.x) + static_cast<std::size_t>(x);
        output.begin_pixel(static_cast<std::uint32_t>(pixel));
        trace_camera_subpath(context, {x, y}, pixel, output);
        frame_[pixel] = output.pixel_sum();
      }
    });
    for (const Output& output : camera_chunks_) counters_ += output.counters;
  }

  void trace_camera_subpath(const Context& context, glm::ivec2 pixel, std::size_t index, Output& output) const {
    ++output.counters.camera_paths;
    Source source(settings_.seed, context.iteration, static_cast<std::uint32_t>(index), camera_stream);
    source.at_vertex(0);
    const Vec2<T> uv_pixel(uniform<T>(source), uniform<T>(source));
    const Vec2<T> uv_lens(uniform<T>(source), uniform<T>(source));
    const auto sample = scene_.camera().sample_ray(pixel, uv_pixel, uv_lens);
    if (!sample) return;

    // The vertex behind and the step that leads away from it.
    SurfacePoint<T> from = sample->origin;
    Step<S> step{sample->direction, sample->weight, sample->density, T(0), false};
    S throughput = sample->weight;
    PartialWeights<T> weights_behind{};
    const bool has_parallel_rays = scene_.camera().has_parallel_rays();

    for (int depth = 1; depth <= context.max_depth; ++depth) {
      ++output.counters.rays;
      auto hit = scene_.intersect(leave(from, step.to_next));
      const auto weights_at = [&](T to_area_back, T density) {
        return depth == 1 ? context.recursion.first_camera_vertex(density)
                          : context.recursion.extend_camera(weights_behind, depth == 2, step.is_delta, step.reverse,
                                                            to_area_back, density);
      };
      const T cos_behind = std::abs(glm::dot(from.geometric_normal, step.to_next));
      if (!hit) {
        if constexpr (Integrator_::template has<EmitterHit>)
          if (step.forward > T(0))
            EmitterHit::at_escape(context, -step.to_next, throughput, weights_at(cos_behind, step.forward), depth, from,
                                  output);
        return;
      }

      const Vec3<T> offset = hit->point.position - from.position;
      const T distance_squared = glm::dot(offset, offset);
      const T cos_here = std::abs(glm::dot(hit->point.geometric_normal, step.to_next));
      const T density = step.forward * (depth == 1 && has_parallel_rays ? cos_here : cos_here / distance_squared);
      if (!is_usable_density(density)) {
        ++output.counters.rejected_zero_pdf;
        return;
      }
      CameraVertex<Sc> vertex{*hit, -step.to_next, throughput, weights_at(cos_behind / distance_squared, density),
                              {},   depth};
      if constexpr (Integrator_::template has<EmitterHit>) EmitterHit::at_camera_vertex(context, vertex, from, output);
      if (depth == context.max_depth) return;

      const T survival = survival_probability(vertex.hit.bsdf);
      if (survival == T(0)) return;  // nothing is scattered on
      vertex.children = {survival, survival * context.split.nominal_children(vertex.hit.bsdf)};

      if (!vertex.hit.bsdf.is_purely_delta()) {
        if constexpr (Integrator_::template has<NextEvent>) {
          source.at_vertex(2 * static_cast<std::uint32_t>(depth));
          NextEvent::at_camera_vertex(context, vertex, source, output);
        }
        if constexpr (Integrator_::template has<Connect>)
          for (const LightVertex<Sc>& light : paired_tree(index))
            if (light.depth + depth < context.max_depth) Connect::connect(context, vertex, light, output);
        if constexpr (Integrator_::template has<Merge>) Merge::at_camera_vertex(context, vertex, output);
      }

      source.at_vertex(2 * static_cast<std::uint32_t>(depth) + 1);
      const auto next = scatter(vertex.hit.bsdf, vertex.hit.point, vertex.to_prev, TransportMode::radiance, survival,
                                vertex.children, source);
      if (!next) return;
      step = *next;
      throughput = throughput * step.weight;
      from = vertex.hit.point;
      weights_behind = vertex.weights;
    }
  }

  void add_splats() {
    const Stopwatch stopwatch(seconds_.film);
    for (const LightChunk& chunk : light_chunks_)
      for (const auto& splat : chunk.output.splats()) frame_[splat.pixel] += splat.value;
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
  typename Integrator_::Split::template Policy<T> split_;
  std::size_t light_tree_count_ = 0;
  std::vector<LightChunk> light_chunks_;
  std::vector<Output> camera_chunks_;
  std::vector<const LightVertex<Sc>*> vertices_;
  LightVertexGrid<T> grid_;
  std::vector<S> frame_;
  Counters counters_;
  PhaseSeconds seconds_;
  std::uint32_t iteration_ = 0;
  bool is_prepared_ = false;
};

}  // namespace gmis
