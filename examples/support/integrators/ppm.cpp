#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_ppm(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::Ppm>(scene, request);
}

}  // namespace gmis::tools
