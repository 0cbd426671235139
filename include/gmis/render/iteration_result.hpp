#pragma once

#include <span>

#include "gmis/core/spectrum.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// What an iteration gives to a run.
template <Spectrum S>
struct IterationResult {
  std::span<const S> frame;               ///< of the rows of this rank
  std::span<const float> merging_change;  ///< of the same pixels; empty when merging is off
  double merged_light = 0.0;              ///< of all pixels, as `AnyEngine::merged_light`
  double cpu_seconds = 0.0;               ///< of the rank that rendered it
  EngineWork work;                        ///< of this iteration

  /// Reads or writes all but the pixels.
  template <class Archive>
  void exchange_numbers(Archive& archive) {
    archive(merged_light, cpu_seconds, work);
  }
};

}  // namespace gmis
