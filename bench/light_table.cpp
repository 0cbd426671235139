// Lights chosen by a learned table (transport/lights/): what it gains in variance, what it costs in time, and what is left of both.
//
//   light_table [ITERATIONS [SIZE [SCENE.pbrt …]]]
//
// Every scene is rendered by path tracing and by bidirectional path tracing with lights chosen by power, and by a table over that, one iteration
// after the other on one thread. The error of N iterations is the variance of one over N, relative to the picture as relMSE is. Training counts as
// time.

#include <cmath>
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

template <template <class> class Engine>
void compare(const std::string& name, const char* integrator, const Scene& scene, const Learned& learned,
             const gmis::SampleCounts& counts, int iterations, double training) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 10;
  gmis_bench::Run<Engine<Scene>, Scene> plain(scene, settings);
  settings.seed = 1;
  gmis_bench::Run<Engine<Learned>, Learned> with_table(learned, settings);
  for (int i = 0; i < iterations; ++i) {
    plain.iterate();
    with_table.iterate();
  }
  const auto mean = [&](std::size_t i) { return (plain.mean(i) + with_table.mean(i)) / 2; };
  const auto before = gmis_bench::trimmed_and_whole(plain.relative_variances(mean));
  const auto after = gmis_bench::trimmed_and_whole(with_table.relative_variances(mean));
  const double cost = (with_table.seconds() + training / iterations) / plain.seconds();
  std::printf("| %s | %s | %.2f | %.2f | %.1f | %.2f | %.2f | %.4f ± %.4f |\n", name.c_str(), integrator,
              before[1] / after[1], with_table.seconds() / plain.seconds(), training / plain.seconds(),
              before[1] / after[1] / cost, before[0] / after[0] / cost, with_table.total() / plain.total(),
              std::hypot(with_table.total_error(), plain.total_error()) / plain.total());
  std::fflush(stdout);
}

template <class S>
using TwoSides = gmis::Engine<S>;
template <class S>
using OneSide = gmis::PathTracer<S>;

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
    compare<OneSide>(name, "pt", scene, learned, gmis::integrators::pt, iterations, training);
    compare<TwoSides>(name, "bpt", scene, learned, gmis::integrators::bpt, iterations, training);
  }
  std::printf("\n%d iterations, %dx%d pixels, one thread.\n", iterations, size, size);
}
