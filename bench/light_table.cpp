// Lights chosen by a learned table (transport/lights/): what it gains in variance, what it costs in time, and what is left of both.
//
//   light_table [ITERATIONS [SIZE [SCENE.pbrt …]]]
//
// Every scene is rendered by path tracing and by bidirectional path tracing with lights chosen by power, and by a table over that, one iteration
// after the other on one thread. The error of N iterations is the variance of one over N, relative to the picture as relMSE is. Training counts as
// time.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "gmis/transport/integrators.hpp"
#include "gmis/transport/lights/learn_lights.hpp"
#include "paired_runs.hpp"
#include "support/build_scene.hpp"
#include "support/diagnostics.hpp"
#include "support/pbrt/reader.hpp"

namespace {

using Scene = gmis::tools::BuiltScene::SceneType;
using Learned = gmis::LightTableScene<Scene>;

void print(const std::string& name, const char* integrator, const gmis_bench::Comparison& found, int iterations,
           double training) {
  const double cost = found.cost(training, iterations);
  std::printf("| %s | %s | %.2f | %.2f | %.1f | %.2f | %.2f | %.4f ± %.4f |\n", name.c_str(), integrator,
              found.before[1] / found.after[1], found.other_seconds / found.plain_seconds,
              training / found.plain_seconds, found.before[1] / found.after[1] / cost,
              found.before[0] / found.after[0] / cost, found.ratio, found.ratio_error);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int iterations = argc > 1 ? std::atoi(argv[1]) : 64, size = argc > 2 ? std::atoi(argv[2]) : 64;
  std::vector<std::string> scenes(argv + std::min(argc, 3), argv + argc);
  if (iterations < 2 || size < 1) {
    std::fprintf(stderr, "usage: light_table [ITERATIONS [SIZE [SCENE.pbrt …]]]\n");
    return 2;
  }
  if (scenes.empty())
    for (const char* name :
         {"many_lights", "mixed", "tempting/two_scales", "tempting/panes", "tempting/none_narrow", "one_point_light"})
      scenes.push_back("bench/scenes/" + std::string(name) + ".pbrt");
  std::printf(
      "| scene | integrator | variance, by power/by table | time, by table/by power | training, in iterations | "
      "efficiency | "
      "without the worst 0.1 %% | mean, by table/by power |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const std::string& file : scenes) {
    gmis::tools::Diagnostics diagnostics;
    gmis::tools::SceneDescription description = gmis::tools::read_pbrt_scene(file, diagnostics);
    description.film.width = description.film.height = size;
    const auto built = gmis::tools::build_scene(description, diagnostics);
    const Scene& scene = built->scene();
    gmis::SerialExecutor executor;
    const double start = gmis_bench::processor_seconds();
    const auto table = gmis::learn_lights(scene, {.seed = 1, .max_depth = 10, .rounds = 2, .paths = 4096}, executor);
    const double training = gmis_bench::processor_seconds() - start;
    const Learned learned(scene, table);
    const std::string name = std::filesystem::path(file).stem().string();
    using gmis_bench::compare;
    print(name, "pt", compare<gmis_bench::OneSide>(scene, learned, gmis::integrators::pt, iterations), iterations,
          training);
    print(name, "bpt", compare<gmis_bench::TwoSides>(scene, learned, gmis::integrators::bpt, iterations), iterations,
          training);
  }
  std::printf("\n%d iterations, %dx%d pixels, one thread.\n", iterations, size, size);
}
