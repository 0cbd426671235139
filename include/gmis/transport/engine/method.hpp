#pragma once

#include "gmis/transport/context/no_split.hpp"
#include "gmis/transport/state/film_output.hpp"
#include "gmis/transport/walk/light_path.hpp"
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

/// Weights for camera subpaths alone, each with one ratio of densities: emitter hits and next
/// events.
template <class Heuristic>
struct CameraSideWeights {
  /// Camera subpaths alone.
  static constexpr bool has_light_side = false;
  template <std::floating_point T>
  using Recursion = CameraWeightRecursion<T, Heuristic>;
};

/// Light subpaths do not split.
struct LightPaths {
  template <std::floating_point T>
  using Split = NoSplit<T>;
  /// Traces a light subpath.
  template <class Context, class Output>
  using Walk = LightPath<Context, Output>;
};

/// The parts of an engine that are fixed at compile time. The techniques are not among them:
/// `SampleCounts` select them at run time.
///
/// - `Weights`: the recursion that forms the weights.
/// - `Output<S>`: a `ChunkOutput`, which receives the contributions.
/// - `Light`: how light subpaths are traced: `Light::Walk<Context, Output>`, with the `SplitPolicy`
///   `Light::Split<T>`.
template <class Weights_, template <class> class Output_ = FilmOutput, class Light = LightPaths>
struct Method {
  using Weights = Weights_;
  template <Spectrum S>
  using Output = Output_<S>;
  template <std::floating_point T>
  using Split = typename Light::template Split<T>;
  /// Traces light subpaths, as `Light` does.
  template <class Context, class AnyOutput>
  using LightWalk = typename Light::template Walk<Context, AnyOutput>;
};

/// All techniques; light trees are paths without branches.
using BothSides = Method<RecursiveWeights<BalanceRatio>>;
/// Emitter hits and next events (path tracing), without light subpaths; each weight has one ratio
/// of densities.
using CameraSide = Method<CameraSideWeights<BalanceRatio>>;

}  // namespace gmis
