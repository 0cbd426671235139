#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_split_pt_lt(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::SplitCamera<integrators::PtLt>>(scene, request);
}

}  // namespace gmis::tools
