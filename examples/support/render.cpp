#include "support/render.hpp"

#include "support/auto_integrator.hpp"
#include "support/progressive_render.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start(const BuiltScene& scene, const RenderRequest& request) {
  switch (request.integrator) {
    case IntegratorChoice::automatic:
      return start_auto(scene, request);
    case IntegratorChoice::pt:
      return request.classifies ? start_classified_pt(scene, request) : start_pt(scene, request);
    case IntegratorChoice::lt:
      return start_lt(scene, request);
    case IntegratorChoice::bpt:
      return request.classifies ? start_classified_bpt(scene, request) : start_bpt(scene, request);
    case IntegratorChoice::ppm:
      return start_ppm(scene, request);
    case IntegratorChoice::bpm:
      return start_bpm(scene, request);
    case IntegratorChoice::vcm:
      return request.classifies ? start_classified_vcm(scene, request) : start_vcm(scene, request);
    case IntegratorChoice::gmis:
      break;
  }
  switch (request.split) {
    case SplitChoice::none:
      // Without splitting, gmis is vcm.
      return request.classifies ? start_classified_vcm(scene, request) : start_vcm(scene, request);
    case SplitChoice::paper:
      return start_gmis_paper(scene, request);
    case SplitChoice::budgeted:
    case SplitChoice::adaptive:  // the same engine with other settings
      break;
  }
  return start_gmis_budgeted(scene, request);
}

RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  executor.stop_when(nullptr);
  ProgressiveRender rendering(scene, request);
  std::optional<StopReason> reason;
  double last_picture = 0;
  while (!reason) {
    if (!rendering.advance(executor)) {
      reason = StopReason::interrupt;
      break;
    }
    if (request.on_iteration) request.on_iteration(rendering.progress());
    reason = rendering.reason_to_stop();
    const double seconds = rendering.progress().seconds;
    if (!reason && request.on_picture && seconds - last_picture >= request.seconds_between_pictures) {
      last_picture = seconds;
      request.on_picture(rendering.image());
    }
    executor.stop_when(request.interrupted);  // there is something to show from now on
  }
  executor.stop_when(nullptr);
  rendering.finish_log();
  return rendering.result(*reason);
}

}  // namespace gmis::tools
