#include "support/auto_integrator.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "support/plan_text.hpp"

namespace gmis::tools {

namespace {

std::array<bool, technique_count> all_on(const Plan& plan) {
  std::array<bool, technique_count> on{};
  for (std::size_t i = 0; i < technique_count; ++i) on[i] = plan.techniques[i].is_on;
  return on;
}

}  // namespace

Plan plan_for_scene(const BuiltScene& scene, const RenderSettings& settings) {
  return plan_for(effects_of(scene.scene()), settings.max_depth, settings.path_classes);
}

std::array<bool, technique_count> techniques_of(const RenderRequest& request, const Plan& plan) {
  const IntegratorChoice integrator = request.integrator;
  std::array<bool, technique_count> on{};
  const auto set = [&](Technique technique, bool is_on) { on[static_cast<std::size_t>(technique)] = is_on; };
  if (integrator == IntegratorChoice::automatic) {
    for (const TechniquePlan& technique : plan.techniques) set(technique.technique, technique.is_on);
    return on;
  }
  set(Technique::emitter_hit, true);
  set(Technique::next_event, integrator == IntegratorChoice::pt || connects(integrator));
  set(Technique::connect, connects(integrator));
  set(Technique::splat, integrator == IntegratorChoice::lt || connects(integrator));
  set(Technique::merge, merges(integrator));
  return on;
}

std::unique_ptr<FrameSource> start_plan(const Plan& plan, const BuiltScene& scene, const RenderRequest& request) {
  const bool classifies = request.classifies;
  if (plan.has(Technique::connect)) {
    if (plan.has(Technique::merge))
      return classifies ? start_classified_vcm(scene, request) : start_vcm(scene, request);
    return classifies ? start_classified_bpt(scene, request) : start_bpt(scene, request);
  }
  if (plan.has(Technique::merge))
    return classifies ? start_classified_pt_lt_pm(scene, request) : start_pt_lt_pm(scene, request);
  if (plan.has(Technique::splat))
    return classifies ? start_classified_pt_lt(scene, request) : start_pt_lt(scene, request);
  return classifies ? start_classified_pt(scene, request) : start_pt(scene, request);
}

std::vector<Candidate> candidates_for(const Plan& plan, const RenderRequest& request) {
  const RenderSettings& settings = request.settings;
  CandidateCounts counts;
  // What was asked for by number is not chosen.
  if (request.fixes_light_paths) counts.light_paths = {settings.light_paths};
  if (settings.connections != measured_connections) counts.connections = {settings.connections};
  if (!plan.has(Technique::merge)) counts.merges = {false};
  std::vector<Candidate> candidates = all_candidates(counts);
  std::erase_if(candidates, [&](const Candidate& candidate) {
    std::array<bool, technique_count> on{};
    for (const TechniquePlan& technique : plan.techniques) {
      const Technique t = technique.technique;
      const bool has = t == Technique::connect ? candidate.connections > 0
                       : t == Technique::splat ? candidate.splats
                       : t == Technique::merge ? candidate.merges
                                               : true;
      on[static_cast<std::size_t>(t)] = technique.is_on && has;
    }
    return !(lacking_classes(plan, on) - lacking_classes(plan, all_on(plan))).is_empty();
  });
  return candidates;
}

std::unique_ptr<FrameSource> start_candidate(const Candidate& candidate, const BuiltScene& scene,
                                             const RenderRequest& request) {
  RenderRequest chosen = request;
  chosen.settings.camera_children = candidate.camera_children;
  const bool splits = candidate.camera_children > 1;
  if (!candidate.traces_light()) return splits ? start_split_pt(scene, chosen) : start_pt(scene, chosen);
  chosen.settings.light_paths = candidate.light_paths;
  chosen.settings.connections = std::max(1, candidate.connections);
  const auto start = candidate.connections > 0 ? (candidate.merges ? (splits ? start_split_vcm : start_vcm)
                                                                   : (splits ? start_split_bpt : start_bpt))
                     : candidate.merges        ? (splits ? start_split_pt_lt_pm : start_pt_lt_pm)
                                               : (splits ? start_split_pt_lt : start_pt_lt);
  return start(scene, chosen);
}

std::uint32_t expected_iterations(const Budget& budget, std::size_t pixels) {
  constexpr double operations_a_pixel = 20.0;  // of one iteration, in scenes of the kind that this is used for
  const std::uint32_t named =
      budget.iterations.value_or(budget.seconds ? std::numeric_limits<std::uint32_t>::max() : 64);
  if (!budget.seconds) return named;
  const double in_time = *budget.seconds * nominal_operations_per_second /
                         (operations_a_pixel * static_cast<double>(std::max<std::size_t>(1, pixels)));
  return std::min(named, static_cast<std::uint32_t>(std::clamp(in_time, 1.0, 1e6)));
}

bool measures(const Plan& plan, const RenderRequest& request) {
  // Where classes or techniques are told apart, or trees are paired, the plan alone decides.
  return request.integrator == IntegratorChoice::automatic && !request.classifies && !request.techniques &&
         request.settings.connections != paired_connections && plan.has(Technique::connect) &&
         plan.has(Technique::splat);
}

std::unique_ptr<FrameSource> start_auto(const BuiltScene& scene, const RenderRequest& request) {
  const Plan plan = plan_for_scene(scene, request.settings);
  if (!measures(plan, request)) return start_plan(plan, scene, request);
  std::vector<Candidate> candidates = candidates_for(plan, request);
  if (candidates.size() < 2) return start_plan(plan, scene, request);
  return plan.has(Technique::merge) ? start_measured_vcm(scene, request, std::move(candidates))
                                    : start_measured_bpt(scene, request, std::move(candidates));
}

}  // namespace gmis::tools
