#pragma once

#include "gmis/transport/output/film_output.hpp"
#include "gmis/transport/walk/split.hpp"
#include "gmis/transport/weights/camera_weights.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"

namespace gmis {

/// Weights from the recursion over light and camera subpaths, for any set of techniques.
template <class Heuristic>
struct RecursiveWeights {
  /// Light trees take part.
  static constexpr bool has_light_side = true;
  template <std::floating_point T>
  using Recursion = WeightRecursion<T, Heuristic>;
};

/// Weights for camera subpaths alone, each with one ratio of densities: emitter hits and next events.
template <class Heuristic>
struct CameraSideWeights {
  /// Camera subpaths alone.
  static constexpr bool has_light_side = false;
  template <std::floating_point T>
  using Recursion = CameraWeightRecursion<T, Heuristic>;
};

/// The parts of an engine that are fixed at compile time. The techniques are not among them: `SampleCounts` select them
/// at run time.
///
/// - `Weights`: the recursion that forms the weights.
/// - `Split<T>`: a `SplitPolicy`.
/// - `Output<S>`: a `ChunkOutput`, which receives the contributions.
template <class Weights_, template <class> class Split_ = PathSplit, template <class> class Output_ = FilmOutput>
struct Method {
  using Weights = Weights_;
  template <std::floating_point T>
  using Split = Split_<T>;
  template <Spectrum S>
  using Output = Output_<S>;
};

/// All techniques; light trees are paths without branches.
using BothSides = Method<RecursiveWeights<BalanceRatio>>;
/// Emitter hits and next events (path tracing), without light subpaths; each weight has one ratio of densities.
using CameraSide = Method<CameraSideWeights<BalanceRatio>>;
/// All techniques; light trees branch [Liu, Algorithm 1].
using SplitTrees = Method<RecursiveWeights<BalanceRatio>, QueueSplit>;

}  // namespace gmis
