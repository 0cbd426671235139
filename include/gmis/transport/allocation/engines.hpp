#pragma once

#include <memory>

#include "gmis/transport/allocation/engine_maker.hpp"
#include "gmis/transport/engine/engine.hpp"

namespace gmis {

/// Engines for `scene`, which must outlive them: `CameraSide` when no light subpath is traced, else
/// `BothSides`. Without a pilot: a run with several candidates is refused.
template <Scene Sc, class Source = SampleNumbers>
[[nodiscard]] EngineMaker<typename Sc::Spectrum> engines_of(const Sc& scene) {
  using S = typename Sc::Spectrum;
  return {.engine = [&scene](const RenderSettings& settings,
                             const std::optional<PixelBounds>& crop) -> std::unique_ptr<AnyEngine<S>> {
            if (settings.counts.traces_light())
              return std::make_unique<Engine<Sc, BothSides, Source>>(scene, settings, crop);
            return std::make_unique<Engine<Sc, CameraSide, Source>>(scene, settings, crop);
          },
          .pilot = {}};
}

}  // namespace gmis
