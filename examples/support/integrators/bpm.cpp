#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_bpm(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Bpm>(scene, request, executor);
}

}  // namespace gmis::tools
