#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/transport/allocation/any_pilot.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/weights/weights_by_technique.hpp"

namespace gmis {

/// Weights with a separate sum of densities for each technique.
struct SeparateWeights {
  /// Light trees take part.
  static constexpr bool has_light_side = true;
  template <std::floating_point T>
  using Recursion = WeightRecursion<T, BalanceRatio, SeparateSums<T>>;
};

/// The engine of a pilot: all techniques, with the density of each contribution by each of them.
using PilotMethod = Method<SeparateWeights, PilotOutput>;

/// Renders a part of the pixels with all techniques, and forecasts variance, bias and cost of every
/// candidate (`AnyPilot`).
template <Scene Sc, class Source = SampleNumbers>
class RenderPilot final : public AnyPilot<typename Sc::Spectrum> {
 public:
  using S = typename Sc::Spectrum;
  using EngineType = Engine<Sc, PilotMethod, Source>;

  /// The candidates may use the techniques that are on in `settings.counts`; connections and splats
  /// must be on there. All candidates that merge must agree with it in `local_merges`. The pilot
  /// merges with a constant radius: the largest of all candidates, whose disk has the mean area of
  /// a run of `expected_iterations`. The scene must outlive the pilot.
  GMIS_RARE RenderPilot(const Sc& scene, const RenderSettings& settings, const std::vector<SampleCounts>& candidates,
                        std::uint32_t expected_iterations, const std::optional<PixelBounds>& crop = std::nullopt)
      : AnyPilot<S>(validated_candidates(scene, settings, candidates), counts_of_pilot(settings.counts, candidates)),
        engine_(scene,
                settings_of_pilot(scene, settings, counts_of_pilot(settings.counts, candidates), expected_iterations),
                crop) {
    std::vector<PilotOutput<S>*> outputs;
    engine_.for_each_output([&](PilotOutput<S>& output) { outputs.push_back(&output); });
    this->observe(std::move(outputs), scene.camera().resolution(), expected_iterations);
  }

  void iterate(ExecutorRef executor) override {
    engine_.iterate(executor);
    this->end_iteration(engine_.photon_count());
  }
  void learn_lights(std::uint64_t seed, ExecutorRef executor) override { engine_.learn_lights(seed, executor); }
  [[nodiscard]] const EngineType& engine() const noexcept override { return engine_; }

 private:
  /// The counts of the pilot. Two connections per vertex, because their pairs enter the variance.
  /// Few light trees, an eighth of the largest number among the candidates (of one per pixel at
  /// least), because they are enough to tell the candidates apart.
  [[nodiscard]] static SampleCounts counts_of_pilot(SampleCounts counts, const std::vector<SampleCounts>& candidates) {
    double most = 1.0;
    for (const SampleCounts& candidate : candidates) {
      most = std::max(most, candidate.light_paths);
      if (candidate.merges) counts.radius_factor = std::max(counts.radius_factor, candidate.radius_factor);
    }
    counts.light_paths = most / 8.0;
    counts.connections = 2;
    return counts;
  }

  /// Throws for a candidate that the run would refuse once it is chosen: the pilot itself has an
  /// alpha, a sampler and counts of its own.
  [[nodiscard]] static const std::vector<SampleCounts>& validated_candidates(
      const Sc& scene, RenderSettings settings, const std::vector<SampleCounts>& candidates) {
    for (const SampleCounts& candidate : candidates) {
      settings.counts = candidate;
      (void)validated<Sc, PilotMethod, Source>(settings, scene.camera().resolution(),
                                               typename EngineType::Split::Settings{});
    }
    return candidates;
  }

  [[nodiscard]] static RenderSettings settings_of_pilot(const Sc& scene, RenderSettings settings,
                                                        const SampleCounts& made, std::uint32_t expected_iterations) {
    settings.radius =
        settings.radius.value_or(default_radius(scene)) * std::sqrt(mean_disk(settings.alpha, expected_iterations));
    settings.alpha = 1.0;
    settings.sampler = Sampler::independent;  // forecasts compare iterations
    settings.counts = made;
    return settings;
  }

  EngineType engine_;
};

}  // namespace gmis
