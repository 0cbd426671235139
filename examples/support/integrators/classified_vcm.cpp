#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_classified_vcm(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<Classified<integrators::Vcm>>(scene, request);
}

}  // namespace gmis::tools
