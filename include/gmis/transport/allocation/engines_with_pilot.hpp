#pragma once

#include <memory>

#include "gmis/transport/allocation/engines.hpp"
#include "gmis/transport/allocation/pilot.hpp"

namespace gmis {

/// `engines_of(scene)`, and a pilot that chooses among candidates for the counts.
template <Scene Sc, class Source = SampleNumbers>
[[nodiscard]] EngineMaker<typename Sc::Spectrum> engines_with_pilot(const Sc& scene) {
  using S = typename Sc::Spectrum;
  EngineMaker<S> maker = engines_of<Sc, Source>(scene);
  maker.pilot = [&scene](const RenderSettings& settings, const std::vector<SampleCounts>& candidates,
                         std::uint32_t expected_iterations,
                         const std::optional<PixelBounds>& crop) -> std::unique_ptr<AnyPilot<S>> {
    return std::make_unique<RenderPilot<Sc, Source>>(scene, settings, candidates, expected_iterations, crop);
  };
  return maker;
}

}  // namespace gmis
