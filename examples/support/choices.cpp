#include "support/choices.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "gmis/transport/integrators.hpp"
#include "support/plan_text.hpp"

namespace gmis::tools {

Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings) {
  return plan_for(effects_of(scene.scene()), settings.max_depth, settings.path_classes.value_or(PathClassSet::all()),
                  settings.counts.local_merges);
}

SampleCounts counts_of(IntegratorChoice integrator, const Plan& plan) {
  switch (integrator) {
    case IntegratorChoice::automatic:
      return integrators::vcm.only([&](Technique technique) { return plan.has(technique); });
    case IntegratorChoice::pt:
      return integrators::pt;
    case IntegratorChoice::lt:
      return integrators::lt;
    case IntegratorChoice::bpt:
      return integrators::bpt;
    case IntegratorChoice::ppm:
      return integrators::ppm;
    case IntegratorChoice::bpm:
      return integrators::bpm;
    case IntegratorChoice::vcm:
    case IntegratorChoice::gmis:
      break;
  }
  return integrators::vcm;
}

std::vector<SampleCounts> candidates_for(const Plan& plan, const SampleCounts& counts, OpenCounts open) {
  CountChoices choices;
  if (!open.light_paths) choices.light_paths = {counts.light_paths};
  if (!open.connections)
    choices.connections = {counts.connections};
  else if (!open.techniques)
    choices.connections = {1, 2};
  if (!open.techniques) choices.merges = {counts.merges};
  if (open.radius) choices.radius_factors = local_radius_factors;
  if (!open.camera_children) choices.camera_children = {counts.camera_children};
  std::vector<SampleCounts> candidates = all_candidates(counts, choices);
  const PathClassSet lacking = lacking_classes(plan, counts);
  std::erase_if(candidates, [&](const SampleCounts& candidate) {
    return !(lacking_classes(plan, candidate) - lacking).is_empty();
  });
  return candidates;
}

std::uint32_t expected_iterations(const Budget& budget, std::size_t pixels, int threads) {
  constexpr double operations_a_pixel = 20.0;  // of one iteration, in scenes of the kind that this is used for
  const std::uint32_t named =
      budget.iterations.value_or(budget.seconds ? std::numeric_limits<std::uint32_t>::max() : 64);
  if (!budget.seconds) return named;
  const double in_time = *budget.seconds * nominal_operations_per_second * std::max(1, threads) /
                         (operations_a_pixel * static_cast<double>(std::max<std::size_t>(1, pixels)));
  return std::min(named, static_cast<std::uint32_t>(std::clamp(in_time, 1.0, 1e6)));
}

void set_counts(RenderRequest& request, const Options& options, const BuiltScene& scene) {
  const bool is_automatic = options.integrator == IntegratorChoice::automatic;
  const SplitChoice split = options.integrator == IntegratorChoice::gmis ? options.split : SplitChoice::none;
  const bool is_local = is_automatic || split == SplitChoice::local;
  request.settings.counts.local_merges = is_local;
  const Plan plan = plan_for_scene(scene, request.settings);
  SampleCounts counts = counts_of(options.integrator, plan);
  // Nothing is to be merged where no surface makes photons.
  if (is_local && plan[Technique::merge].makes.is_empty()) counts.merges = false;
  counts.local_merges = is_local && counts.merges;
  if (counts.local_merges && !request.settings.radius) counts.radius_factor = integrators::vcm_local.radius_factor;
  if (counts.traces_light()) counts.light_paths = options.light_paths.value_or(1.0);
  if (counts.connections != 0 && options.connections) counts.connections = *options.connections;
  if (options.integrator == IntegratorChoice::gmis) counts.camera_children = options.camera_split;
  request.settings.counts = counts;
  if (split == SplitChoice::budgeted) request.settings.light_split = LightSplit::budgeted;
  if (split == SplitChoice::paper) request.settings.light_split = LightSplit::paper;

  // A pilot keeps no contributions, connects with vertices from the cache and splats.
  request.candidates.clear();
  if (request.techniques || request.class_images || !counts.draws_connections() || !counts.splats) return;
  if (is_automatic && request.settings.path_classes) return;  // the plan of the classes alone decides
  OpenCounts open;
  open.techniques = is_automatic;
  open.light_paths = is_automatic && !options.light_paths;
  open.connections = !options.connections;
  open.camera_children = is_automatic || split == SplitChoice::adaptive;
  open.radius = counts.local_merges && !request.settings.radius;
  if (auto candidates = candidates_for(plan, counts, open); candidates.size() > 1)
    request.candidates = std::move(candidates);
}

}  // namespace gmis::tools
