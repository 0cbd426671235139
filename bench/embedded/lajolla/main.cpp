#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string_view>
#include <vector>

#include "gmis/render/automatic_request.hpp"
#include "gmis/render/render.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"

#include "adapter.hpp"
#include "parsers/parse_scene.h"
#include "path_tracing.h"

// One of lajolla's scenes, rendered on one thread by lajolla's path tracer or by the engine over
// the adapter. Prints processor seconds without the construction of the scene, and rays.
// Usage: PROGRAM FILE WIDTH MAX_DEPTH lajolla|pt|bpt|vcm|auto COUNT SEED PICTURE
// COUNT: samples of a pixel, or iterations.

namespace {
using Picture = std::vector<glm::dvec3>;  // rows from above

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

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

template <class EngineType>
Picture by_engine(const adapter::Scene& scene, const gmis::RenderSettings& settings, int iterations) {
  EngineType engine(scene, settings);
  gmis::SerialExecutor serial;
  Picture picture;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(serial);
    picture.resize(engine.frame().size());
    for (std::size_t p = 0; p < picture.size(); ++p) picture[p] += glm::dvec3(engine.frame()[p]) / double(iterations);
  }
  return picture;
}

Picture by_auto(const adapter::Scene& scene, int max_depth, int iterations, std::uint64_t seed) {
  gmis::RenderSettings settings = gmis::settings_with(gmis::Sampler::sobol);
  settings.seed = seed;
  settings.max_depth = max_depth;
  gmis::SerialExecutor serial;
  const auto request = gmis::automatic_request(scene, {.iterations = std::uint32_t(iterations)}, 1, settings);
  const gmis::RenderResult result = gmis::Render(scene, request).run(serial);
  Picture picture;
  for (std::size_t p = 0; p < result.picture.values.size(); p += 3)
    picture.emplace_back(result.picture.values[p], result.picture.values[p + 1], result.picture.values[p + 2]);
  return picture;
}

bool write(const char* file, const Picture& picture, int width, int height) {
  std::FILE* out = std::fopen(file, "wb");
  if (!out) return false;
  std::fprintf(out, "PF\n%d %d\n-1\n", width, height);
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3 pixel(picture[std::size_t(y * width + x)]);
      std::fwrite(&pixel, sizeof pixel, 1, out);
    }
  return std::fclose(out) == 0;
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
  gmis::RenderSettings settings;
  settings.seed = std::uint64_t(seed);
  settings.max_depth = max_depth;
  rays_traced = 0;
  const double before = processor_seconds();
  Picture picture;
  if (what == "lajolla") {
    picture = by_lajolla(*theirs, count, settings.seed);
  } else if (what == "pt") {
    settings.counts = gmis::integrators::pt;
    picture = by_engine<gmis::PathTracer<adapter::Scene>>(scene, settings, count);
  } else if (what == "bpt" || what == "vcm") {
    settings.counts = what == "bpt" ? gmis::integrators::bpt : gmis::integrators::vcm;
    picture = by_engine<gmis::Engine<adapter::Scene>>(scene, settings, count);
  } else if (what == "auto") {
    picture = by_auto(scene, max_depth, count, settings.seed);
  } else {
    return EXIT_FAILURE;
  }
  std::printf("%.4f %.0f\n", processor_seconds() - before, double(rays_traced));
  return write(argv[7], picture, theirs->camera.width, theirs->camera.height) ? EXIT_SUCCESS : EXIT_FAILURE;
}
