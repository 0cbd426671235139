#include <cstdio>
#include <gmis/check/check_scene.hpp>
#include <gmis/render.hpp>
#include <gmis/render/thread_executor.hpp>

#include "adapter.hpp"

// A town with many lamps, rendered with lamps chosen for their receiver and with all lamps chosen
// alike: the estimated errors of both after the same number of iterations.

namespace {

template <class Scene>
double relative_error(const Scene& scene) {
  const gmis::Findings findings = gmis::check_scene(scene);
  std::fputs(findings.text().c_str(), stderr);
  if (!findings.passes()) return -1;
  gmis::ThreadExecutor threads;
  gmis::RenderRequest request;
  request.settings.counts = gmis::integrators::pt;
  request.settings.max_depth = 4;
  request.budget.iterations = 64;
  request.intervals = true;
  const gmis::RenderResult result = gmis::Render(scene, request).run(threads);
  return result.is_trustworthy && result.error ? result.error->relative_error : -1;
}

}  // namespace

int main() {
  const town::Town town = town::make_town(48, 64, 48);
  const double by_grid = relative_error(many_lights::Scene<true>(town));
  const double alike = relative_error(many_lights::Scene<false>(town));
  std::printf("relative error: %.4f with lamps chosen for their receiver, %.4f with all chosen alike\n", by_grid,
              alike);
  return by_grid > 0 && by_grid < alike ? 0 : 1;
}
