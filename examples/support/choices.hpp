#pragma once

#include <cstdint>
#include <vector>

#include "gmis/transport/effects/plan.hpp"
#include "support/render.hpp"

/// \file
/// From the options to the counts of a run: those of the integrator that was asked for; with `--integrator auto`, those that
/// the scene calls for, and others to choose from.

namespace gmis::tools {

/// By the scene's effects, the depth of paths, the classes that are wanted and whether merging has a local count.
[[nodiscard]] Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings);

/// The counts of an integrator; those of `auto` are all techniques of the plan, each once.
[[nodiscard]] SampleCounts counts_of(IntegratorChoice integrator, const Plan& plan);

/// The counts that are left open: what a pilot may choose.
struct OpenCounts {
  bool light_paths = false, connections = false, camera_children = false;
  bool radius = false;      ///< the factor on the merging radius
  bool techniques = false;  ///< the plan's techniques may be left out where others make the same classes
};

/// Counts to choose from. Every candidate makes some paths of each class that the plan's techniques make. Only one when
/// nothing is open.
[[nodiscard]] std::vector<SampleCounts> candidates_for(const Plan& plan, const SampleCounts& counts, OpenCounts open);

/// The expected number of iterations of a budget, before anything was rendered: the number that it names, at most as many
/// as fit in its time by the nominal speed of each thread (no clock is read); 64 where it has neither. `pixels`: of the
/// crop.
[[nodiscard]] std::uint32_t expected_iterations(const Budget& budget, std::size_t pixels, int threads);

/// Sets the counts of `request` and the candidates that it chooses from, by what its integrator and split policy mean in
/// this scene. `options` say which counts were asked for by number.
void set_counts(RenderRequest& request, const Options& options, const BuiltScene& scene);

}  // namespace gmis::tools
