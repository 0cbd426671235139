#include "support/integrators/measured_source.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_measured_bpt(const BuiltScene& scene, const RenderRequest& request,
                                                std::vector<Candidate> candidates) {
  return std::make_unique<MeasuredSource<integrators::Bpt>>(scene, request, std::move(candidates));
}

}  // namespace gmis::tools
