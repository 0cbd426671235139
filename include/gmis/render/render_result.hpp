#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gmis/render/contribution_sums.hpp"
#include "gmis/render/picture.hpp"
#include "gmis/result/budget.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/merging_bias.hpp"
#include "gmis/result/time_to_error.hpp"
#include "gmis/transport/allocation/choice.hpp"
#include "gmis/transport/engine/any_engine.hpp"

namespace gmis {

/// Settings that a run has chosen, and its time, work and memory so far.
struct RunFacts {
  double cpu_seconds = 0.0;            ///< of all threads of the process: pilot, iterations, estimates of the error
  PhaseSeconds phases;                 ///< wall time by phase
  std::optional<PriceTable> forecast;  ///< of the usual errors, as the pilot's choice had them before the run
  Counters counters;                   ///< operations of whole iterations, and what was rejected
  std::vector<RejectedPath> rejected_paths;  ///< the first ones
  SampleCounts counts;                       ///< of the last iteration
  std::optional<Choice> choice;              ///< of a pilot that has finished
  LightUse lights;                           ///< how lights were chosen, and where light subpaths started
  double radius = 0.0;           ///< merging radius r_1 of the last iteration, in scene units; 0: merging is off
  std::size_t photon_bytes = 0;  ///< memory of the stored light vertices
};

/// Everything about a finished run except its pictures.
struct RenderSummary : RunFacts {
  StopReason stopped_by = StopReason::iterations;  ///< why the run ended
  std::vector<std::uint64_t> joined_seeds;         ///< of runs that were joined (`join_runs`), else empty
  std::uint32_t iterations = 0;                    ///< in the picture: not those of a pilot
  double wall_seconds = 0.0;                       ///< of the pilot, the iterations and the estimates of the error
  ImageEstimate estimate;                          ///< mean, variance and error of the picture
  std::optional<ErrorEstimate> error;              ///< with `RenderRequest::intervals`, from the second iteration on
  std::optional<PriceTable> prices;  ///< of the usual errors, then of half the present one; empty while unknown
  /// The bias of merging, relative like the error, which does not contain it; 0 when nothing was
  /// merged. Empty after one iteration that merges.
  std::optional<MergingBias> merging_bias;
  std::vector<ConvergencePoint> log;  ///< its last point is the last iteration
  bool is_trustworthy = true;         ///< false: rejections exceed `RenderRequest::rejection_limit`
};

/// A finished run.
struct RenderResult : RenderSummary {
  Picture picture;  ///< the mean of the iterations
  /// Estimated variance of every value of `picture`. Without values before two iterations; with
  /// dependent iterations (`Sampler::sobol`) it needs `RenderRequest::intervals` and two
  /// replications.
  Picture variance;
  Picture half_a;                            ///< with `RenderRequest::halves`: mean of iterations 1, 3, 5 …
  Picture half_b;                            ///< with `RenderRequest::halves`: mean of iterations 2, 4, 6 …
  std::vector<TechniquePicture> techniques;  ///< with `RenderRequest::techniques`
  ClassPictures classes;                     ///< with `RenderRequest::class_pictures`
  std::vector<LightPicture> by_light;        ///< with `RenderRequest::light_pictures`
};

}  // namespace gmis
