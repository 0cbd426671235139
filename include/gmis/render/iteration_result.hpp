#pragma once

#include <span>
#include <vector>

#include "gmis/core/spectrum.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// Pixels, work and time of one iteration.
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

/// An iteration of a part of a run, with everything that a run takes in.
template <Spectrum S>
struct KeptIteration {
  IterationResult<S> numbers;         ///< its pixels are below
  std::vector<S> frame;               ///< of the picture
  std::vector<float> merging_change;  ///< of the same pixels; empty when merging is off
  double radius = 0.0;                ///< of its merging disk

  /// The iteration, which refers to this.
  [[nodiscard]] IterationResult<S> result() const {
    IterationResult<S> all = numbers;
    all.frame = frame;
    all.merging_change = merging_change;
    return all;
  }

  /// The state for a later run (`core/state_archive.hpp`).
  template <class Archive>
  void exchange_state(Archive& archive) {
    numbers.exchange_numbers(archive);
    archive(frame, merging_change, radius);
  }
};

}  // namespace gmis
