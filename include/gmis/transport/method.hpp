#pragma once

#include "gmis/transport/output/film_output.hpp"
#include "gmis/transport/walk/split.hpp"
#include "gmis/transport/weights/camera_weights.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"

namespace gmis {

/// Weights from the recursion over both subpaths: any techniques.
template <class Heuristic>
struct RecursiveWeights {
  static constexpr bool has_light_side = true;
  template <std::floating_point T>
  using Recursion = WeightRecursion<T, Heuristic>;
};

/// Weights of camera subpaths alone, each one ratio: emitter hits and next events.
template <class Heuristic>
struct CameraSideWeights {
  static constexpr bool has_light_side = false;
  template <std::floating_point T>
  using Recursion = CameraWeightRecursion<T, Heuristic>;
};

/// The parts that are fixed when an engine is compiled. Which techniques run is not among them: `SampleCounts` say that at
/// run time, which costs less than half a per cent of the instructions of an engine compiled for them alone.
///
/// - `Weights`: the recursion that the weights are formed with.
/// - `Split<T>`: a `SplitPolicy`.
/// - `Output<S>`: a `PathOutput`, where contributions go.
template <class Weights_, template <class> class Split_ = PathSplit, template <class> class Output_ = FilmOutput>
struct Method {
  using Weights = Weights_;
  template <std::floating_point T>
  using Split = Split_<T>;
  template <Spectrum S>
  using Output = Output_<S>;
};

/// All techniques; light subpaths are paths.
using BothSides = Method<RecursiveWeights<BalanceRatio>>;
/// Emitter hits and next events: path tracing, without a light side and with weights of one ratio.
using CameraSide = Method<CameraSideWeights<BalanceRatio>>;
/// All techniques; light subpaths are trees [Liu, Algorithm 1].
using SplitTrees = Method<RecursiveWeights<BalanceRatio>, QueueSplit>;

}  // namespace gmis
