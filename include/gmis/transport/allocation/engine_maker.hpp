#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmis/transport/allocation/any_pilot.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// Makes the engines of a run over one scene. Only what a maker names is compiled: `engines_of`
/// (engines alone), `engines_with_pilot` (and a pilot that chooses counts), `gmis_engines` (light
/// trees that split).
template <Spectrum S>
struct EngineMaker {
  /// The engine for these settings; it throws `std::invalid_argument` for settings that it cannot
  /// render with.
  std::function<std::unique_ptr<AnyEngine<S>>(const RenderSettings&, const std::optional<PixelBounds>&)> engine;
  /// A pilot for candidates and a run of a number of iterations; empty when these engines have
  /// none.
  std::function<std::unique_ptr<AnyPilot<S>>(const RenderSettings&, const std::vector<SampleCounts>&, std::uint32_t,
                                             const std::optional<PixelBounds>&)>
      pilot;
  /// Properties of the engines beside the settings that change a picture, by name, for the identity
  /// of a run.
  std::vector<std::pair<std::string, std::string>> properties{};
};

}  // namespace gmis
