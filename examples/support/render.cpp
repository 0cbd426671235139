#include "support/render.hpp"

namespace gmis::tools {

RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor) {
  switch (request.integrator) {
    case IntegratorChoice::pt:
      return render_pt(scene, request, executor);
    case IntegratorChoice::lt:
      return render_lt(scene, request, executor);
    case IntegratorChoice::bpt:
      return render_bpt(scene, request, executor);
    case IntegratorChoice::ppm:
      return render_ppm(scene, request, executor);
    case IntegratorChoice::bpm:
      return render_bpm(scene, request, executor);
    case IntegratorChoice::vcm:
      return render_vcm(scene, request, executor);
    case IntegratorChoice::gmis:
      break;
  }
  switch (request.split) {
    case SplitChoice::none:
      return render_vcm(scene, request, executor);  // without splitting, gmis is vcm
    case SplitChoice::paper:
      return render_gmis_paper(scene, request, executor);
    case SplitChoice::budgeted:
    case SplitChoice::adaptive:  // the same engine with other settings
      break;
  }
  return render_gmis_budgeted(scene, request, executor);
}

}  // namespace gmis::tools
