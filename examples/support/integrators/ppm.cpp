#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_ppm(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Ppm>(scene, request, executor);
}

}  // namespace gmis::tools
