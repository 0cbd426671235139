#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_split_pt(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::SplitCamera<integrators::Pt>>(scene, request);
}

}  // namespace gmis::tools
