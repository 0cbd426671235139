#pragma once

#include <memory>
#include <string>

#include "gmis/transport/allocation/engines.hpp"
#include "gmis/transport/splitting/split_trees.hpp"

namespace gmis {

/// Engines for `scene`, which must outlive them, whose light trees split [Liu, Algorithm 1]:
/// `SplitTrees` when light subpaths are traced, else `CameraSide`. Without a pilot.
template <Scene Sc, class Source = SampleNumbers>
[[nodiscard]] EngineMaker<typename Sc::Spectrum> gmis_engines(const Sc& scene, const GmisSampler& sampler) {
  using S = typename Sc::Spectrum;
  return {.engine = [&scene, sampler](const RenderSettings& settings,
                                      const std::optional<PixelBounds>& crop) -> std::unique_ptr<AnyEngine<S>> {
            if (settings.counts.traces_light())
              return std::make_unique<Engine<Sc, SplitTrees, Source>>(scene, settings, crop, sampler);
            return std::make_unique<Engine<Sc, CameraSide, Source>>(scene, settings, crop);
          },
          .pilot = {},
          .properties = {{"the scheme", std::string(name_of(sampler.scheme))},
                         {"the number of rounds", std::to_string(sampler.rounds)},
                         {"the budget of light trees", std::to_string(sampler.budget)},
                         {"the end of the budget of light trees",
                          sampler.at_end_of_budget == TreeBudget::cut ? "cut" : "softened"}}};
}

}  // namespace gmis
