#include "support/render.hpp"

#include "support/progressive_render.hpp"

namespace gmis::tools {

std::unique_ptr<SceneEngine> start(const BuiltScene& scene, const RenderRequest& request) {
  auto engine = std::make_unique<SceneEngine>(scene.scene(), request.settings, request.candidates,
                                              request.expected_iterations, request.crop);
  engine->keep_contributions(request.techniques || request.class_images);
  return engine;
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
