#pragma once

#include "gmis/transport/engine.hpp"
#include "gmis/transport/integrators.hpp"

/// \file
/// The integrators as types, so that a test can be written once for all: each with the engine that it needs.

namespace gmis_test::ways {

template <class Method_, const gmis::SampleCounts& base, gmis::LightSplit split = gmis::LightSplit::none,
          class Heuristic_ = gmis::BalanceRatio>
struct Way {
  using Heuristic = Heuristic_;
  using Method = Method_;
  template <class Scene, class Source = gmis::SampleNumbers>
  using Engine = gmis::Engine<Scene, Method, Source>;

  /// The same settings for this integrator: its techniques, with the numbers that `asked` has for them.
  [[nodiscard]] static gmis::RenderSettings settings(gmis::RenderSettings asked = {}) {
    gmis::SampleCounts counts = base;
    if (base.traces_light()) counts.light_paths = asked.counts.light_paths;
    if (base.connections != 0) counts.connections = asked.counts.connections;
    if (base.camera_children != 0) counts.camera_children = asked.counts.camera_children;
    counts.local_merges = asked.counts.local_merges;
    counts.radius_factor = asked.counts.radius_factor;
    asked.counts = counts;
    asked.light_split = split;
    return asked;
  }
  [[nodiscard]] static bool has(gmis::Technique technique) { return base.has(technique); }
  static constexpr bool splits_light = split != gmis::LightSplit::none;
  static constexpr bool camera_stops = base.camera_children == 0;
};

using Pt = Way<gmis::CameraSide, gmis::integrators::pt>;
using Lt = Way<gmis::BothSides, gmis::integrators::lt>;
using PtLt = Way<gmis::BothSides, gmis::integrators::pt_lt>;
using PtLtPm = Way<gmis::BothSides, gmis::integrators::pt_lt_pm>;
using Bpt = Way<gmis::BothSides, gmis::integrators::bpt>;
using Ppm = Way<gmis::BothSides, gmis::integrators::ppm>;
using Bpm = Way<gmis::BothSides, gmis::integrators::bpm>;
using Vcm = Way<gmis::BothSides, gmis::integrators::vcm>;
using Gmis = Way<gmis::SplitTrees, gmis::integrators::vcm, gmis::LightSplit::budgeted>;
using PaperGmis = Way<gmis::SplitTrees, gmis::integrators::vcm, gmis::LightSplit::paper>;

}  // namespace gmis_test::ways
