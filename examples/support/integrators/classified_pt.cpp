#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_classified_pt(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<Classified<integrators::Pt>>(scene, request);
}

}  // namespace gmis::tools
