#include "support/integrators/measured_source.hpp"

namespace gmis::tools {

std::unique_ptr<FrameSource> start_measured_vcm(const BuiltScene& scene, const RenderRequest& request,
                                                std::vector<Candidate> candidates) {
  return std::make_unique<MeasuredSource<integrators::Vcm>>(scene, request, std::move(candidates));
}

}  // namespace gmis::tools
