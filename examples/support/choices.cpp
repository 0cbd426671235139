#include "support/choices.hpp"

#include <utility>

#include "gmis/transport/state/integrators.hpp"

namespace gmis::tools {

Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings) {
  return plan_for(scene.scene(), settings);
}

SampleCounts counts_of(IntegratorChoice integrator, const Plan& plan) {
  switch (integrator) {
    case IntegratorChoice::automatic:
      return gmis::counts_of(plan);
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
  const bool is_radius_free = counts.local_merges && !request.settings.radius;
  counts.radius_factor = is_radius_free ? integrators::vcm_local.radius_factor : 1.0;
  if (counts.traces_light()) counts.light_paths = options.light_paths.value_or(1.0);
  if (counts.connections != 0 && options.connections) counts.connections = *options.connections;
  counts.connects_paired_tree = counts.connections != 0 && options.connects_paired_tree;
  request.settings.counts = counts;
  request.sampler.reset();
  if (split == SplitChoice::budgeted || split == SplitChoice::paper)
    request.sampler =
        GmisSampler{.scheme = options.scheme,
                    .at_end_of_budget = split == SplitChoice::paper ? TreeBudget::cut : TreeBudget::softened};

  // A pilot connects with vertices from the cache and splats.
  request.candidates.clear();
  if (request.class_pictures || !counts.draws_connections() || !counts.splats) return;
  if (is_automatic && request.settings.path_classes) return;  // the plan of the classes alone decides
  OpenCounts open;
  open.techniques = is_automatic;
  open.light_paths = is_local && !options.light_paths;
  open.connections = !options.connections && !options.connects_paired_tree;
  open.radius = is_radius_free;
  if (auto candidates = candidates_for(plan, counts, open); candidates.size() > 1)
    request.candidates = std::move(candidates);
}

}  // namespace gmis::tools
