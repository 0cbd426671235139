#include <cstdio>
#include <gmis/check/check_scene.hpp>
#include <gmis/render.hpp>
#include <gmis/render/thread_executor.hpp>

#include "room.hpp"

// A room rendered with Embree's intersector, after a check of the adapter.

int main() {
  const embree::Scene scene(room::build(48, 36), room::triangles());
  const gmis::Findings findings = gmis::check_scene(scene);
  std::fputs(findings.text().c_str(), stderr);
  gmis::ThreadExecutor threads;
  const auto request = gmis::automatic_request(scene, {.iterations = 16}, threads.thread_count());
  const gmis::RenderResult result = gmis::Render(scene, request).run(threads);
  std::printf("mean %.4f, variance of a pixel %.2g\n", result.estimate.mean, result.estimate.variance);
  return findings.passes() && result.is_trustworthy ? 0 : 1;
}
