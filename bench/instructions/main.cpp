// Renders iterations of one integrator, for callgrind to count: the built-in scene and the engines,
// no more. Counted by `./run bench instructions --check`.
//
// Usage: instruction_counts SCENE.pbrt INTEGRATOR ITERATIONS SIZE

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/build_scene.hpp"
#include "support/diagnostics.hpp"
#include "support/pbrt/reader.hpp"

namespace {

using Scene = gmis::tools::BuiltScene::SceneType;

template <class Engine>
double mean_after(const Scene& scene, const gmis::RenderSettings& settings, int iterations) {
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  double sum = 0.0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    for (const auto& pixel : engine.frame()) sum += static_cast<double>(pixel.x + pixel.y + pixel.z);
  }
  return sum / (3.0 * iterations * static_cast<double>(engine.frame().size()));
}

std::optional<gmis::SampleCounts> counts_of(std::string_view integrator) {
  using namespace gmis::integrators;
  gmis::SampleCounts counts = integrator == "pt"    ? pt
                              : integrator == "lt"  ? lt
                              : integrator == "ppm" ? ppm
                              : integrator == "bpm" ? bpm
                              : integrator == "bpt" ? bpt
                                                    : vcm;
  if (integrator == "bpt" || integrator == "vcm")
    counts.connects_paired_tree = true;
  else if (counts.connections != 0)
    return {};
  return counts;
}

}  // namespace

int main(int argc, char** argv) {
  const auto counts = argc == 5 ? counts_of(argv[2]) : std::nullopt;
  if (!counts) {
    std::fprintf(stderr, "Usage: instruction_counts SCENE.pbrt pt|lt|ppm|bpm|bpt|vcm ITERATIONS SIZE\n");
    return 2;
  }
  gmis::tools::Diagnostics diagnostics;
  gmis::tools::SceneDescription description = gmis::tools::read_pbrt_scene(argv[1], diagnostics);
  description.film.width = description.film.height = std::atoi(argv[4]);
  const auto built = gmis::tools::build_scene(description, diagnostics);

  gmis::RenderSettings settings;
  settings.counts = *counts;
  settings.max_depth = 10;
  settings.alpha = 0.75;
  settings.radius = 0.00665118;  // SmallVCM's, in scene units
  const int iterations = std::atoi(argv[3]);
  const double mean = settings.counts.traces_light()
                          ? mean_after<gmis::Engine<Scene>>(built->scene(), settings, iterations)
                          : mean_after<gmis::PathTracer<Scene>>(built->scene(), settings, iterations);
  std::printf("%s %.9g\n", argv[2], mean);
}
