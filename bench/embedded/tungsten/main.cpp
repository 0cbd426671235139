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
#include "integrators/bidirectional_path_tracer/BidirectionalPathTracer.hpp"
#include "integrators/path_tracer/PathTracer.hpp"
#include "load.hpp"
#include "sampling/UniformPathSampler.hpp"

// One of Tungsten's scenes, rendered on one thread by Tungsten's path tracers or by the engine over
// the adapter. Prints processor seconds without the construction of the scene.
// Usage: PROGRAM FILE MAX_DEPTH tungsten|tungsten_bdpt|pt|bpt|vcm|auto COUNT SEED PICTURE
// COUNT: samples of a pixel, or iterations. MAX_DEPTH: segments of a path.

namespace {
using Picture = std::vector<glm::dvec3>;  // rows from above
using Tungsten::uint32, Tungsten::Vec2u, Tungsten::Vec3f;

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// The mean of `sample(pixel)` over `count` samples of each pixel.
template <class Sample>
Picture mean_by_pixel(const Tungsten::Camera& camera, int count, Sample sample) {
  Picture picture;
  for (uint32 y = 0; y < camera.resolution().y(); ++y)
    for (uint32 x = 0; x < camera.resolution().x(); ++x) {
      Vec3f sum(0.f);
      for (int i = 0; i < count; ++i) sum += sample(Vec2u(x, y));
      picture.push_back(glm::dvec3(adapter::ours(sum)) / double(count));
    }
  return picture;
}

Picture by_path_tracing(Tungsten::TraceableScene& scene, int max_depth, int count, int seed) {
  Tungsten::PathTracerSettings settings;
  settings.maxBounces = max_depth;
  Tungsten::PathTracer tracer(&scene, settings, 0);
  Tungsten::UniformPathSampler numbers{uint32(seed)};
  return mean_by_pixel(scene.cam(), count, [&](Vec2u pixel) { return tracer.traceSample(pixel, numbers); });
}

Picture by_bidirectional_path_tracing(Tungsten::TraceableScene& scene, int max_depth, int count, int seed) {
  Tungsten::BidirectionalPathTracerSettings settings;
  settings.maxBounces = max_depth;
  scene.cam().requestSplatBuffer();
  Tungsten::BidirectionalPathTracer tracer(&scene, settings, 0, nullptr);
  Tungsten::UniformPathSampler numbers{uint32(seed)};
  Picture picture =
      mean_by_pixel(scene.cam(), count, [&](Vec2u pixel) { return tracer.traceSample(pixel, 0, numbers); });
  const uint32 width = scene.cam().resolution().x();
  for (std::size_t p = 0; p < picture.size(); ++p)
    picture[p] += glm::dvec3(adapter::ours(Vec3f(scene.cam().splatBuffer()->get(int(p % width), int(p / width))))) /
                  (double(picture.size()) * count);
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

Picture by_auto(const adapter::Scene& scene, int max_depth, int iterations, int seed) {
  gmis::RenderSettings settings = gmis::settings_with(gmis::Sampler::sobol);
  settings.seed = std::uint64_t(seed);
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
  if (argc != 7) return EXIT_FAILURE;
  const adapter::Loaded loaded(argv[1]);
  Tungsten::TraceableScene& theirs = *loaded.traceable;
  const int max_depth = std::atoi(argv[2]), count = std::atoi(argv[4]), seed = std::atoi(argv[5]);
  const std::string_view what = argv[3];
  const adapter::Scene scene(theirs);
  gmis::RenderSettings settings;
  settings.seed = std::uint64_t(seed);
  settings.max_depth = max_depth;
  const double before = processor_seconds();
  Picture picture;
  if (what == "tungsten") {
    picture = by_path_tracing(theirs, max_depth, count, seed);
  } else if (what == "tungsten_bdpt") {
    picture = by_bidirectional_path_tracing(theirs, max_depth, count, seed);
  } else if (what == "pt") {
    settings.counts = gmis::integrators::pt;
    picture = by_engine<gmis::PathTracer<adapter::Scene>>(scene, settings, count);
  } else if (what == "bpt" || what == "vcm") {
    settings.counts = what == "bpt" ? gmis::integrators::bpt : gmis::integrators::vcm;
    picture = by_engine<gmis::Engine<adapter::Scene>>(scene, settings, count);
  } else if (what == "auto") {
    picture = by_auto(scene, max_depth, count, seed);
  } else {
    return EXIT_FAILURE;
  }
  std::printf("%.4f\n", processor_seconds() - before);
  const glm::ivec2 size = scene.camera().resolution();
  return write(argv[6], picture, size.x, size.y) ? EXIT_SUCCESS : EXIT_FAILURE;
}
