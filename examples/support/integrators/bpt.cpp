#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_bpt(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Bpt>(scene, request, executor);
}

}  // namespace gmis::tools
