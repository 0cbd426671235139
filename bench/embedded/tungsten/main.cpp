#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>

#include "../pictures.hpp"
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
using embedded::Picture;
using Tungsten::uint32, Tungsten::Vec2u, Tungsten::Vec3f;

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
}  // namespace

int main(int argc, char* argv[]) {
  if (argc != 7) return EXIT_FAILURE;
  const adapter::Loaded loaded(argv[1]);
  Tungsten::TraceableScene& theirs = *loaded.traceable;
  const int max_depth = std::atoi(argv[2]), count = std::atoi(argv[4]), seed = std::atoi(argv[5]);
  const std::string_view what = argv[3];
  const adapter::Scene scene(theirs);
  const double before = embedded::processor_seconds();
  std::optional<Picture> picture;
  if (what == "tungsten") {
    picture = by_path_tracing(theirs, max_depth, count, seed);
  } else if (what == "tungsten_bdpt") {
    picture = by_bidirectional_path_tracing(theirs, max_depth, count, seed);
  } else {
    picture = embedded::by_gmis(what, scene, max_depth, count, std::uint64_t(seed));
  }
  if (!picture) return EXIT_FAILURE;
  std::printf("%.4f\n", embedded::processor_seconds() - before);
  const glm::ivec2 size = scene.camera().resolution();
  return embedded::write(argv[6], *picture, size.x, size.y) ? EXIT_SUCCESS : EXIT_FAILURE;
}
