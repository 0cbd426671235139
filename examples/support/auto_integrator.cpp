#include "support/auto_integrator.hpp"

namespace gmis::tools {

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

std::unique_ptr<FrameSource> start_auto(const BuiltScene& scene, const RenderRequest& request) {
  return start_plan(plan_for_scene(scene, request.settings), scene, request);
}

}  // namespace gmis::tools
