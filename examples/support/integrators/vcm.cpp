#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_vcm(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Vcm>(scene, request, executor);
}

}  // namespace gmis::tools
