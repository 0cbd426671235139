#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/concept_diagnostics.hpp"
#include "gmis/core/guided_light.hpp"
#include "gmis/render/render_request.hpp"
#include "gmis/transport/allocation/forecast.hpp"
#include "gmis/transport/plan/plan.hpp"
#include "gmis/transport/state/integrators.hpp"

/// \file
/// From the effects of a scene to the counts of a run: the techniques that the effects call for,
/// and candidates for a pilot to choose from.

namespace gmis {

/// The plan for the effects of a scene, the greatest path length, the path classes of the settings,
/// and whether merging has a local count there.
template <Scene Sc>
[[nodiscard]] Plan plan_for(const Sc& scene, const RenderSettings& settings) {
  return plan_for(effects_of(scene), settings.max_depth, settings.path_classes.value_or(PathClassSet::all()),
                  settings.counts.local_merges);
}

/// The techniques of the plan, each with one sample, and merging as the plan has it.
[[nodiscard]] inline SampleCounts counts_of(const Plan& plan) {
  const SampleCounts all = plan.local_merges ? integrators::vcm_local : integrators::vcm;
  SampleCounts counts = all.only([&](Technique technique) { return plan.has(technique); });
  if (!counts.merges) counts.local_merges = false, counts.radius_factor = 1.0;
  return counts;
}

/// The counts that a pilot may choose; the others keep their values.
struct OpenCounts {
  bool light_paths = false;  ///< light trees per pixel
  bool connections = false;  ///< connections per camera vertex
  bool radius = false;       ///< the factor on the merging radius
  bool techniques = false;   ///< techniques may be left out where the remaining ones make the same path classes
};

/// The requested classes that these counts do not cover: no enabled technique makes their paths
/// from delta lights, or none makes those from the other lights.
[[nodiscard]] constexpr PathClassSet lacking_classes(const Plan& plan, const SampleCounts& counts) {
  const PathClassSet lacking = PathClassSet::where([&](const PathFeatures& f) {
    for (const bool is_delta : {false, true}) {
      if (!(is_delta ? plan.effects.has_delta_lights() && f.scatterings > 0 : plan.effects.has_extended_lights()))
        continue;
      bool is_made = false;
      for (const Technique technique : all_techniques)
        is_made = is_made || (counts.has(technique) && makes_some(technique, f, is_delta, counts.local_merges));
      if (!is_made) return true;
    }
    return false;
  });
  return lacking & plan.classes;
}

/// Candidates for a pilot: `counts` with every combination of values for the open ones. Each
/// candidate makes all classes that `counts` make. The result has one entry when nothing is open.
GMIS_RARE [[nodiscard]] inline std::vector<SampleCounts> candidates_for(const Plan& plan, const SampleCounts& counts,
                                                                        const OpenCounts& open) {
  CountChoices choices;
  if (!open.light_paths)
    choices.light_paths = {counts.light_paths};
  else if (!open.techniques)
    std::erase(choices.light_paths, 0.0);
  if (!open.connections)
    choices.connections = {counts.connections};
  else if (!open.techniques)
    choices.connections = {1, 2};
  if (!open.techniques) choices.merges = {counts.merges};
  if (open.radius) choices.radius_factors = local_radius_factors;
  std::vector<SampleCounts> candidates = all_candidates(counts, choices);
  const PathClassSet lacking = lacking_classes(plan, counts);
  std::erase_if(candidates, [&](const SampleCounts& candidate) {
    return !(lacking_classes(plan, candidate) - lacking).is_empty();
  });
  return candidates;
}

/// The expected number of iterations of a budget: its own limit on iterations, at most the number
/// that fits in its time at `nominal_operations_per_second` per thread; 64 when it limits neither.
/// No clock is read, so that the choice of a pilot does not depend on the machine. `pixels`: of the
/// crop.
[[nodiscard]] inline std::uint32_t expected_iterations(const Budget& budget, std::size_t pixels, int threads) {
  constexpr double operations_per_pixel = 20.0;  // of one iteration, in scenes like those of bench/scenes
  const std::uint32_t named =
      budget.iterations.value_or(budget.seconds ? std::numeric_limits<std::uint32_t>::max() : 64);
  if (!budget.seconds) return named;
  const double in_time = *budget.seconds * nominal_operations_per_second * std::max(1, threads) /
                         (operations_per_pixel * static_cast<double>(std::max<std::size_t>(1, pixels)));
  // `Render` refuses a time that is not a number. Until then the cast must not see it, as it would
  // by std::clamp.
  return std::min(named, static_cast<std::uint32_t>(std::fmax(1.0, std::fmin(in_time, 1e6))));
}

/// Default settings with the given sampler.
[[nodiscard]] inline RenderSettings settings_with(Sampler sampler) {
  RenderSettings settings;
  settings.sampler = sampler;
  return settings;
}

/// A request for the whole frame of this scene: the techniques that its effects call for, with
/// counts that a pilot chooses. Emission is learned and guided where that pays. Merging has a local
/// count, and its radius is chosen unless `settings` have one. `settings.counts` are replaced;
/// without your own settings, numbers are Sobol' points, in replications that the error estimate
/// knows of (`Sampler::sobol`). A budget without any limit becomes one of 64 iterations. `threads`
/// of the executor turn a time into an expected number of iterations.
template <Scene Sc>
GMIS_RARE [[nodiscard]] RenderRequest automatic_request(const Sc& scene, const Budget& budget, int threads = 1,
                                                        RenderSettings settings = settings_with(Sampler::sobol)) {
  RenderRequest request;
  request.budget = budget;
  if (!budget.iterations && !budget.seconds && !budget.relative_error) request.budget.iterations = 64;
  settings.counts.local_merges = true;
  if constexpr (GuidableLight<typename Sc::Light>) settings.emission = Emission::learned;
  const Plan plan = plan_for(scene, settings);
  settings.counts = counts_of(plan);
  if (settings.radius) settings.counts.radius_factor = 1.0;
  request.settings = settings;
  request.intervals = true;
  const glm::ivec2 size = scene.camera().resolution();
  request.expected_iterations =
      expected_iterations(request.budget, static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y), threads);
  // A pilot connects with vertices from the cache and splats.
  if (settings.counts.draws_connections() && settings.counts.splats && !settings.path_classes) {
    auto candidates =
        candidates_for(plan, settings.counts, {true, true, settings.counts.merges && !settings.radius, true});
    if (candidates.size() > 1) request.candidates = std::move(candidates);
  }
  return request;
}

/// \cond
// For a type that is no scene: the compiler names what it lacks.
template <class Sc>
requires(!Scene<Sc>) IsScene<Sc> automatic_request(const Sc&, const Budget&, int = 1, const RenderSettings& = {});
/// \endcond

}  // namespace gmis
