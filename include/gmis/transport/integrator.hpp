#pragma once

#include <type_traits>

#include "gmis/transport/camera_weights.hpp"
#include "gmis/transport/contribution.hpp"
#include "gmis/transport/partial_weights.hpp"
#include "gmis/transport/path_filter.hpp"
#include "gmis/transport/split.hpp"
#include "gmis/transport/technique_list.hpp"
#include "gmis/transport/techniques/connect.hpp"
#include "gmis/transport/techniques/emitter_hit.hpp"
#include "gmis/transport/techniques/merge.hpp"
#include "gmis/transport/techniques/next_event.hpp"
#include "gmis/transport/techniques/splat.hpp"

namespace gmis {

/// How far camera subpaths go: on from every surface, or on through delta lobes alone, so that each ends at the first
/// surface that scatters otherwise.
enum class CameraWalk { whole, specular };

/// A way to render: which techniques, how subpaths split, how far camera subpaths go, and the heuristic for the weights.
template <class TechniqueList_, class Split_ = NoSplit, CameraWalk camera_walk_ = CameraWalk::whole,
          class Heuristic_ = BalanceRatio>
struct Integrator {
  using TechniqueList = TechniqueList_;
  using Split = Split_;
  using Heuristic = Heuristic_;
  /// Where contributions go.
  template <Spectrum S, bool records_techniques>
  using Output = ChunkOutput<S, records_techniques>;
  /// What subpaths know of their events, and which paths are wanted.
  using Path = NoHalfPath;
  using Filter = NoPathFilter;
  static constexpr CameraWalk camera_walk = camera_walk_;
  template <class T>
  static constexpr bool has = TechniqueList::template contains<T>;
  static constexpr bool stores_light_vertices = has<Connect> || has<Merge>;
  static constexpr bool traces_light = stores_light_vertices || has<Splat>;
  /// What weights are formed with.
  template <std::floating_point T>
  using Recursion = std::conditional_t<traces_light, WeightRecursion<T, Heuristic>,
                                       CameraWeightRecursion<T, Heuristic, has<EmitterHit>, has<NextEvent>>>;
  /// What is done at a camera vertex that is not purely specular.
  static constexpr bool works_at_camera_vertices = has<NextEvent> || has<Connect> || has<Merge>;
};

/// The same, with the class of every path known: its contributions carry it, and only those of
/// `RenderSettings::path_classes` are made. A subpath ends where it can become part of none of these.
template <class Integrator_>
struct Classified : Integrator_ {
  using Path = HalfPath;
  using Filter = PathFilter;
};

}  // namespace gmis
