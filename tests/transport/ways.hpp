#pragma once

#include <concepts>
#include <optional>

#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/splitting/split_trees.hpp"
#include "gmis/transport/state/integrators.hpp"

/// \file
/// The integrators as types, so that a test can be written once for all: each with the engine that
/// it needs.

namespace gmis_test::ways {

/// The settings of a run, and those of light trees that split; integrators that do not split leave
/// the latter alone.
struct Settings : gmis::RenderSettings {
  Settings() = default;
  Settings(const gmis::RenderSettings& of_run) : gmis::RenderSettings(of_run) {}  // NOLINT: meant to convert
  gmis::GmisSampler sampler;
};

template <class Method_, const gmis::SampleCounts& base, gmis::TreeBudget at_end = gmis::TreeBudget::softened,
          class Heuristic_ = gmis::BalanceRatio>
struct Way {
  using Heuristic = Heuristic_;
  using Method = Method_;
  static constexpr bool splits_light = Method::template Split<float>::is_measured;
  static constexpr bool extends_camera = base.extends_camera;

  template <class Scene, class Source = gmis::SampleNumbers>
  class Engine : public gmis::Engine<Scene, Method, Source> {
    using Base = gmis::Engine<Scene, Method, Source>;

   public:
    Engine(const Scene& scene, const Settings& settings, const std::optional<gmis::PixelBounds>& crop = std::nullopt)
        : Base(scene, settings, crop, split_settings(settings)) {}

   private:
    static typename Base::Split::Settings split_settings(const Settings& settings) {
      if constexpr (splits_light)
        return settings.sampler;
      else
        return {};
    }
  };

  /// The same settings for this integrator: its techniques, with the numbers that `asked` has for
  /// them.
  [[nodiscard]] static Settings settings(Settings asked = {}) {
    gmis::SampleCounts counts = base;
    if (base.traces_light()) counts.light_paths = asked.counts.light_paths;
    if (base.connections != 0) {
      counts.connections = asked.counts.connections;
      counts.connects_paired_tree = asked.counts.connects_paired_tree;
    }
    counts.local_merges = asked.counts.local_merges;
    counts.radius_factor = asked.counts.radius_factor;
    asked.counts = counts;
    asked.sampler.at_end_of_budget = at_end;
    return asked;
  }
  [[nodiscard]] static bool has(gmis::Technique technique) { return base.has(technique); }
};

using Pt = Way<gmis::CameraSide, gmis::integrators::pt>;
using Lt = Way<gmis::BothSides, gmis::integrators::lt>;
using PtLt = Way<gmis::BothSides, gmis::integrators::pt_lt>;
using PtLtPm = Way<gmis::BothSides, gmis::integrators::pt_lt_pm>;
using Bpt = Way<gmis::BothSides, gmis::integrators::bpt>;
using Ppm = Way<gmis::BothSides, gmis::integrators::ppm>;
using Bpm = Way<gmis::BothSides, gmis::integrators::bpm>;
using Vcm = Way<gmis::BothSides, gmis::integrators::vcm>;
using Gmis = Way<gmis::SplitTrees, gmis::integrators::vcm>;
using PaperGmis = Way<gmis::SplitTrees, gmis::integrators::vcm, gmis::TreeBudget::cut>;

}  // namespace gmis_test::ways
