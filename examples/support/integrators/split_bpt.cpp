#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_split_bpt(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::SplitCamera<integrators::Bpt>>(scene, request);
}

}  // namespace gmis::tools
