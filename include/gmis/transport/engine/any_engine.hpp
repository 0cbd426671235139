#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/executor_ref.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/transport/emission/any_learned_lights.hpp"
#include "gmis/transport/state/path_output.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"
#include "gmis/transport/state/rejection.hpp"
#include "gmis/transport/state/settings.hpp"

namespace gmis {

/// Seconds of wall time spent in each phase, measured by the calling thread and summed over
/// iterations.
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

/// Work of some iterations of an engine.
struct EngineWork {
  Counters counters;        ///< counted operations
  Counters light_work;      ///< the part of `counters` that light trees took
  RejectionLog rejections;  ///< the first paths with rejections
  PhaseSeconds seconds;     ///< wall time by phase

  /// The state for another process (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(counters, light_work, rejections, seconds);
  }
};

/// An engine for any scene with the spectrum `S`: the settings of a run, the latest iteration and
/// the work so far. The rendering of an iteration depends on the scene (`Engine`) and is one
/// virtual call, so that code which only uses engines is compiled once per spectrum.
template <Spectrum S>
class AnyEngine {
 public:
  virtual ~AnyEngine() = default;
  AnyEngine(const AnyEngine&) = delete;
  AnyEngine& operator=(const AnyEngine&) = delete;

  /// Renders one more iteration; `frame()` is then the image of this iteration alone.
  virtual void iterate(ExecutorRef executor) = 0;

  /// The next iteration is `iteration` + 1 of the run, which other engines may have rendered so
  /// far: random numbers are not reused, and the merging radius goes on shrinking.
  void continue_after(std::uint32_t iteration) noexcept { iteration_ = iteration; }

  /// Takes the work so far out of the engine, which then has none.
  [[nodiscard]] EngineWork take_work() {
    EngineWork work{counters_, light_work_, std::move(rejections_), seconds_};
    counters_ = light_work_ = {};
    rejections_ = {};
    seconds_ = {};
    return work;
  }
  /// Adds the work of later iterations of the run, which another engine may have rendered.
  void add_work(const EngineWork& work) {
    counters_ += work.counters;
    light_work_ += work.light_work;
    rejections_.append(work.rejections);
    seconds_ += work.seconds;
  }

  /// Reads or writes the state for a later run (`core/state_archive.hpp`), between two iterations.
  /// An engine measures again, with the same result, all that it measures before its first
  /// iteration.
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(iteration_, settings_.counts.radius_factor, merging_gain_, counters_, light_work_, rejections_, seconds_);
  }

  /// Learns about the lights with the numbers of `seed` (`learn_lights`), where the settings or the
  /// scene ask for it and nothing is known yet. The first iteration does so with the seed of the
  /// settings.
  virtual void learn_lights(std::uint64_t seed, ExecutorRef executor) = 0;
  /// The knowledge about the lights; null when nothing is known.
  [[nodiscard]] virtual std::shared_ptr<const AnyLearnedLights> learned_lights() const noexcept = 0;
  /// How the iterations use the lights; gains are known from the first iteration on.
  [[nodiscard]] virtual LightUse light_use() const noexcept = 0;
  /// Takes the knowledge of another engine of this scene, before the first iteration; null: none.
  virtual void use_lights(std::shared_ptr<const AnyLearnedLights> lights) = 0;

  /// Sets whether contributions are kept for `for_each_contribution`, from the next iteration on;
  /// initially they are not. They serve for images of single techniques or path classes.
  virtual void keep_contributions(bool keep) = 0;
  /// Calls `visit(contribution)` for every kept contribution of the latest iteration, in a fixed
  /// order.
  virtual void for_each_contribution(const std::function<void(const Contribution<S>&)>& visit) const = 0;

  /// Image of the latest iteration: linear values, rows from the upper left. Pixels outside the
  /// crop are black.
  [[nodiscard]] std::span<const S> frame() const noexcept { return frame_; }
  /// For every pixel of the latest iteration, the merged light minus what a disk of half the radius
  /// would have merged of the same photons: mean over channels, rows from the upper left. Empty
  /// when merging is off.
  [[nodiscard]] std::span<const float> merging_change() const noexcept { return merging_change_; }
  /// Light merged in the latest iteration: mean over channels, summed over the pixels of the crop;
  /// 0 when merging is off.
  [[nodiscard]] double merged_light() const noexcept { return merged_light_; }
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
  /// V̄ / n_L: expected number of stored vertices per light tree. It is measured before the first
  /// iteration when weights depend on it; otherwise it is 0.
  [[nodiscard]] double vertices_per_tree() const noexcept { return vertices_per_tree_; }
  /// Columns and rows of the frame.
  [[nodiscard]] glm::ivec2 resolution() const noexcept { return resolution_; }
  /// The rendered part of the frame.
  [[nodiscard]] const PixelBounds& crop() const noexcept { return crop_; }
  /// n_L: number of light trees per iteration; 0 when no technique needs them.
  [[nodiscard]] std::size_t light_tree_count() const noexcept { return light_tree_count_; }
  /// Bytes held for light vertices and their grid.
  [[nodiscard]] virtual std::size_t photon_bytes() const noexcept = 0;

  /// Merging radius r_1 of the first iteration in scene units; 0 when merging is off.
  [[nodiscard]] double first_radius() const noexcept { return counts().radius_factor * radius_; }
  /// Merging radius of an iteration (from 1) in scene units: r_i = r_1 i^((α−1)/2)
  /// [Hachisuka, Jensen 2009, as Georgiev 2012 eq. 13]; 0 when merging is off.
  [[nodiscard]] double merge_radius(std::uint32_t iteration) const noexcept {
    return first_radius() * std::pow(static_cast<double>(iteration), 0.5 * (settings_.alpha - 1.0));
  }
  /// Merging radius of the latest iteration; 0 before the first one. After `merge_within` it is the
  /// radius that this iteration would have had.
  [[nodiscard]] double radius() const noexcept { return iteration_ > 0 ? merge_radius(iteration_) : 0.0; }

  /// Sets the radius factor from the next iteration on; the shrinking schedule is unchanged. It
  /// must not depend on samples of the iterations that it serves.
  void merge_within(double radius_factor) noexcept { settings_.counts.radius_factor = radius_factor; }
  /// Multiplies merged light by 1 + `per_radius` r_i from the next iteration on (`MergingGain`);
  /// weights stay as they are. It must not depend on samples of the iterations that it serves.
  void scale_merging(double per_radius) noexcept { merging_gain_ = per_radius; }
  /// The `per_radius` of the next iteration.
  [[nodiscard]] double merging_gain() const noexcept { return merging_gain_; }

 protected:
  /// An engine before its first iteration. `crop` is clipped to the frame; without it the whole
  /// frame is rendered.
  GMIS_RARE AnyEngine(const RenderSettings& settings, glm::ivec2 resolution, const std::optional<PixelBounds>& crop);

  RenderSettings settings_;            ///< of the next iteration
  glm::ivec2 resolution_;              ///< columns and rows of the frame
  PixelBounds crop_;                   ///< the rendered part of the frame
  double radius_ = 0.0;                ///< r_1 for a radius factor of 1, in scene units
  double merging_gain_ = 0.0;          ///< q of `MergingGain`
  double vertices_per_tree_ = 0.0;     ///< V̄ / n_L; 0 unless weights depend on it
  double merged_light_ = 0.0;          ///< in the latest iteration, summed over the crop
  std::size_t light_tree_count_ = 0;   ///< n_L
  std::vector<S> frame_;               ///< the image of the latest iteration
  std::vector<float> merging_change_;  ///< by pixel of the latest iteration; empty without merging
  Counters counters_;                  ///< the work of all iterations
  Counters light_work_;                ///< the part of it that light trees took
  RejectionLog rejections_;            ///< the first paths with rejections
  PhaseSeconds seconds_;               ///< wall time by phase, over all iterations
  std::uint32_t iteration_ = 0;        ///< number of the latest iteration, from 1
};

template <Spectrum S>
AnyEngine<S>::AnyEngine(const RenderSettings& settings, glm::ivec2 resolution, const std::optional<PixelBounds>& crop)
    : settings_(settings), resolution_(resolution) {
  crop_ = crop.value_or(PixelBounds{{0, 0}, resolution_});
  crop_.lower = glm::max(crop_.lower, glm::ivec2(0));
  crop_.upper = glm::min(crop_.upper, resolution_);
  const auto width = static_cast<std::size_t>(resolution_.x), height = static_cast<std::size_t>(resolution_.y);
  const std::size_t pixels = width * height;
  frame_.assign(pixels, S(ScalarOf<S>(0)));
  if (counts().traces_light())
    light_tree_count_ =
        static_cast<std::size_t>(std::max(1.0, std::round(counts().light_paths * static_cast<double>(pixels))));
  if (counts().has(Technique::merge)) merging_change_.assign(pixels, 0.0F);
}

#ifdef GMIS_COMPILED
extern template class AnyEngine<Vec3<float>>;
extern template class AnyEngine<Vec3<double>>;
#endif

}  // namespace gmis
