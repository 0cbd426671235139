#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_gmis_paper(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::Gmis<PaperSplit>>(scene, request);
}

}  // namespace gmis::tools
