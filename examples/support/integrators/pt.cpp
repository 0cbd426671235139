#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_pt(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Pt>(scene, request, executor);
}

}  // namespace gmis::tools
