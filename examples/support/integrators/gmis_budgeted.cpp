#include "support/integrators/render_loop.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_gmis_budgeted(const BuiltScene& scene, const RenderRequest& request) {
  return start_with<integrators::Gmis<BudgetedSplit>>(scene, request);
}

}  // namespace gmis::tools
