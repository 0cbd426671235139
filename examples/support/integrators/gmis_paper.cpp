#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

RenderResult render_gmis_paper(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  return run_with<integrators::Gmis<PaperSplit>>(scene, request, executor);
}

}  // namespace gmis::tools
