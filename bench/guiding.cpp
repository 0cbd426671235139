// Guided directions (transport/guiding/): what they gain in variance, what they cost in time, and what is left of both.
//
//   guiding [ITERATIONS [SIZE [INTEGRATOR [SCENE.pbrt …]]]]
//
// Every scene is rendered twice by each integrator, with the guide and without, one iteration after the other on one thread. The
// error of N iterations is the variance of one over N, relative to the picture as relMSE is. Training counts as time.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "gmis/transport/guiding/learn_directions.hpp"
#include "gmis/transport/integrators.hpp"
#include "paired_runs.hpp"
#include "support/build_scene.hpp"
#include "support/diagnostics.hpp"
#include "support/pbrt/reader.hpp"

namespace {

using gmis_bench::OneSide;
using gmis_bench::processor_seconds;
using gmis_bench::TwoSides;
using Scene = gmis::tools::BuiltScene::SceneType;
using Guided = gmis::GuidedScene<Scene>;

template <template <class> class Engine>
void compare(const std::string& name, const char* integrator, const Scene& scene, const gmis::SampleCounts& counts,
             int iterations, const gmis::DirectionGuide<float>& guide, double training) {
  const auto found = gmis_bench::compare<Engine>(scene, Guided(scene, guide), counts, iterations);
  const double cost = found.cost(training, iterations);
  std::printf("| %s | %s | %.4f | %.4f | %.2f | %.2f | %.0f | %.2f | %.2f | %.4f ± %.4f |\n", name.c_str(), integrator,
              found.before[1] * found.plain_seconds, found.after[1] * cost * found.plain_seconds,
              found.before[1] / found.after[1], found.other_seconds / found.plain_seconds,
              training / found.plain_seconds, found.before[1] / found.after[1] / cost,
              found.before[0] / found.after[0] / cost, found.ratio, found.ratio_error);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int iterations = argc > 1 ? std::atoi(argv[1]) : 256, size = argc > 2 ? std::atoi(argv[2]) : 64;
  const std::string wanted = argc > 3 ? argv[3] : "all";
  std::vector<std::string> scenes(argv + std::min(argc, 4), argv + argc);
  if (iterations < 2 || size < 1) {
    std::fprintf(stderr, "usage: guiding [ITERATIONS [SIZE [pt|bpt|vcm|all [SCENE.pbrt …]]]]\n");
    return 2;
  }
  if (scenes.empty())
    for (const char* name : {"bench/scenes/slit", "bench/scenes/light_behind_glass", "examples/scenes/cornell",
                             "bench/scenes/one_point_light", "bench/scenes/open_sky"})
      scenes.push_back(std::string(name) + ".pbrt");
  std::printf(
      "| scene | integrator | relMSE × seconds, plain | guided | variance, plain/guided | time, guided/plain | "
      "training, in iterations | efficiency | "
      "without the worst 0.1 %% | mean, guided/plain |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "|\n");
  for (const std::string& file : scenes) {
    gmis::tools::Diagnostics diagnostics;
    gmis::tools::SceneDescription description = gmis::tools::read_pbrt_scene(file, diagnostics);
    description.film.width = description.film.height = size;
    const auto built = gmis::tools::build_scene(description, diagnostics);
    const Scene& scene = built->scene();
    gmis::SerialExecutor executor;
    const double start = processor_seconds();
    const auto guide = gmis::learn_directions(scene, {.seed = 1, .max_depth = 10}, executor);
    const double training = processor_seconds() - start;
    const std::string name = std::filesystem::path(file).stem().string();
    const auto is_wanted = [&](const char* integrator) { return wanted == "all" || wanted == integrator; };
    if (is_wanted("pt")) compare<OneSide>(name, "pt", scene, gmis::integrators::pt, iterations, guide, training);
    if (is_wanted("bpt")) compare<TwoSides>(name, "bpt", scene, gmis::integrators::bpt, iterations, guide, training);
    if (is_wanted("vcm")) compare<TwoSides>(name, "vcm", scene, gmis::integrators::vcm, iterations, guide, training);
  }
}
