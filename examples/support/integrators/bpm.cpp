#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_bpm(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::Bpm>(scene, request);
}

}  // namespace gmis::tools
