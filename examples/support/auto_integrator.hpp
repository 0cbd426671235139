#pragma once

#include <memory>
#include <vector>

#include "gmis/transport/plan.hpp"
#include "support/render.hpp"

/// \file
/// What `--integrator auto` stands for: the techniques that the scene calls for, with the counts that pay in it.

namespace gmis::tools {

/// By the scene's effects, the depth of paths and the classes that are wanted.
[[nodiscard]] Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings);

/// What is on in a rendering, in the order of `Technique`: those of the integrator that was asked for, with auto those of
/// the plan.
[[nodiscard]] std::array<bool, technique_count> techniques_of(const RenderRequest& request, const Plan& plan);

/// The integrator that has just the techniques of the plan.
[[nodiscard]] std::unique_ptr<FrameSource> start_plan(const Plan& plan, const BuiltScene& scene,
                                                      const RenderRequest& request);

/// Counts to choose from: every candidate makes some paths of each class that the plan's techniques make. Counts that
/// `settings` fix are not varied.
[[nodiscard]] std::vector<Candidate> candidates_for(const Plan& plan, const RenderRequest& request);

/// The integrator that has just the techniques of the candidate, with its counts.
[[nodiscard]] std::unique_ptr<FrameSource> start_candidate(const Candidate& candidate, const BuiltScene& scene,
                                                           const RenderRequest& request);

/// How many iterations a budget stands for, before anything was rendered: those it names, and no more than its time allows
/// by the nominal speed (no clock is read); 64 where it has neither.
[[nodiscard]] std::uint32_t expected_iterations(const Budget& budget, std::size_t pixels);

/// Whether a pilot chooses; otherwise the plan stands.
[[nodiscard]] bool measures(const Plan& plan, const RenderRequest& request);

[[nodiscard]] std::unique_ptr<FrameSource> start_auto(const BuiltScene& scene, const RenderRequest& request);

}  // namespace gmis::tools
