#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_lt(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Lt>(scene, request, executor);
}

}  // namespace gmis::tools
