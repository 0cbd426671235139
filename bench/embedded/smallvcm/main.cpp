#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>

#define NO_OMP
#include "config.hxx"  // of SmallVCM; the others of its headers follow from it in their order

#include "adapter.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"

// One of SmallVCM's scenes, rendered on one thread by the engine over the adapter or by SmallVCM's
// own integrator. Prints the mean luminance of the picture (measure.py).
// Usage: PROGRAM gmis|smallvcm 0|1|2|3 pt|bpt|vcm ITERATIONS

namespace {
constexpr int size = 64;
constexpr int max_segments = 10;
constexpr float radius_factor = .003f, radius_alpha = .75f;

struct Integrator {
  Config::Algorithm theirs;
  gmis::SampleCounts ours;
};

std::optional<Integrator> integrator_named(std::string_view name) {
  if (name == "pt") return Integrator{Config::kPathTracing, gmis::integrators::pt};
  // SmallVCM connects with every vertex of one light path.
  if (name == "bpt") {
    Integrator bpt{Config::kBidirectionalPathTracing, gmis::integrators::bpt};
    bpt.ours.connects_paired_tree = true;
    return bpt;
  }
  if (name == "vcm") {
    Integrator vcm{Config::kVertexConnectionMerging, gmis::integrators::vcm};
    vcm.ours.connects_paired_tree = true;
    return vcm;
  }
  return std::nullopt;
}

template <class EngineType>
double mean_by_gmis(const adapter::Scene& scene, const gmis::RenderSettings& settings, int iterations) {
  EngineType engine(scene, settings);
  gmis::SerialExecutor serial;
  double sum = 0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(serial);
    for (const glm::vec3& pixel : engine.frame()) sum += static_cast<double>(Luminance(adapter::to_vec3f(pixel)));
  }
  return sum / (double(iterations) * size * size);
}

double mean_by_smallvcm(const Scene& scene, Config::Algorithm algorithm, int iterations) {
  Config config;
  config.mScene = &scene;
  config.mAlgorithm = algorithm;
  config.mRadiusFactor = radius_factor;
  config.mRadiusAlpha = radius_alpha;
  const std::unique_ptr<AbstractRenderer> renderer(CreateRenderer(config, 1234));
  renderer->mMaxPathLength = max_segments;
  renderer->mMinPathLength = 0;
  for (int i = 0; i < iterations; ++i) renderer->RunIteration(i);
  Framebuffer picture;
  renderer->GetFramebuffer(picture);
  return static_cast<double>(picture.TotalLuminance()) / (double(size) * size);
}
}  // namespace

int main(int argc, char* argv[]) {
  if (argc != 5) return EXIT_FAILURE;
  const bool by_gmis = std::string_view(argv[1]) == "gmis";
  const int scene_number = std::atoi(argv[2]);
  const std::optional<Integrator> integrator = integrator_named(argv[3]);
  const int iterations = std::atoi(argv[4]);
  if (!integrator || scene_number < 0 || scene_number > 3) return EXIT_FAILURE;

  Scene theirs;
  theirs.LoadCornellBox(Vec2i(size, size), g_SceneConfigs[scene_number]);
  theirs.BuildSceneSphere();
  if (!by_gmis) {
    std::printf("%.6f\n", mean_by_smallvcm(theirs, integrator->theirs, iterations));
    return EXIT_SUCCESS;
  }
  const adapter::Scene scene(theirs);
  gmis::RenderSettings settings;
  settings.counts = integrator->ours;
  settings.max_depth = max_segments;
  settings.alpha = double(radius_alpha);
  settings.radius = double(radius_factor * theirs.mSceneSphere.mSceneRadius);
  // The engine that a renderer would take: path tracing alone needs a smaller one.
  const bool only_paths = integrator->theirs == Config::kPathTracing;
  std::printf("%.6f\n", only_paths ? mean_by_gmis<gmis::PathTracer<adapter::Scene>>(scene, settings, iterations)
                                   : mean_by_gmis<gmis::Engine<adapter::Scene>>(scene, settings, iterations));
}
