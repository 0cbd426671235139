#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>

#include "../pictures.hpp"
#include "adapter.hpp"
#include "parsers/parse_scene.h"
#include "path_tracing.h"

// One of lajolla's scenes, rendered on one thread by lajolla's path tracer or by the engine over
// the adapter. Prints processor seconds without the construction of the scene, and rays.
// Usage: PROGRAM FILE WIDTH MAX_DEPTH lajolla|pt|bpt|vcm|auto COUNT SEED PICTURE
// COUNT: samples of a pixel, or iterations.

namespace {
using embedded::Picture;

Picture by_lajolla(const Scene& scene, int samples, std::uint64_t seed) {
  Picture picture;
  pcg32_state numbers = init_pcg32(seed, seed * 0x9E3779B97F4A7C15);
  for (int y = 0; y < scene.camera.height; ++y)
    for (int x = 0; x < scene.camera.width; ++x) {
      Spectrum sum = make_zero_spectrum();
      for (int i = 0; i < samples; ++i) sum += path_tracing(scene, x, y, numbers);
      picture.emplace_back(sum.x / samples, sum.y / samples, sum.z / samples);
    }
  return picture;
}
}  // namespace

int main(int argc, char* argv[]) {
  if (argc != 8) return EXIT_FAILURE;
  const std::string_view what = argv[4];
  const std::unique_ptr<Scene> theirs = parse_scene(argv[1], rtcNewDevice(nullptr));
  const int width = std::atoi(argv[2]), max_depth = std::atoi(argv[3]);
  theirs->camera.height = theirs->camera.height * width / theirs->camera.width;
  theirs->camera.width = width;
  theirs->options.max_depth = max_depth;
  const adapter::Scene scene(*theirs);
  const int count = std::atoi(argv[5]), seed = std::atoi(argv[6]);
  rays_traced = 0;
  const double before = embedded::processor_seconds();
  std::optional<Picture> picture;
  if (what == "lajolla") {
    picture = by_lajolla(*theirs, count, std::uint64_t(seed));
  } else {
    picture = embedded::by_gmis(what, scene, max_depth, count, std::uint64_t(seed));
  }
  if (!picture) return EXIT_FAILURE;
  std::printf("%.4f %.0f\n", embedded::processor_seconds() - before, double(rays_traced));
  return embedded::write(argv[7], *picture, theirs->camera.width, theirs->camera.height) ? EXIT_SUCCESS : EXIT_FAILURE;
}
