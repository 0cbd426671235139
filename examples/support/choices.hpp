#pragma once

#include "gmis/render/automatic_request.hpp"
#include "support/render.hpp"

/// \file
/// From the options to the counts of a run: those of the integrator that was asked for; with
/// `--integrator auto`, those that the scene calls for, and others to choose from.

namespace gmis::tools {

/// The plan by the scene's effects, the depth of paths, the classes that are wanted and whether
/// merging has a local count.
[[nodiscard]] Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings);

/// The counts of an integrator; those of `auto` are all techniques of the plan, each once.
[[nodiscard]] SampleCounts counts_of(IntegratorChoice integrator, const Plan& plan);

/// Sets the counts of `request` and the candidates that it chooses from, by what its integrator and
/// split policy mean in this scene. `options` say which counts were asked for by number.
void set_counts(RenderRequest& request, const Options& options, const BuiltScene& scene);

}  // namespace gmis::tools
