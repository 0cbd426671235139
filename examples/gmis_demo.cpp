// gmis-demo: one scene, the same time for gmis and for vcm, and what each made of it.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"
#include "support/pbrt/reader.hpp"
#include "support/report/comparison.hpp"
#include "support/report/html_report.hpp"
#include "support/report/tables.hpp"
#include "support/whole_file.hpp"

namespace {

using namespace gmis::tools;
namespace fs = std::filesystem;

std::vector<fs::path> write_pictures(const ContenderRecord& contender, const fs::path& folder) {
  std::vector<std::string> endings;
  if (has_exr()) endings.push_back(".exr");
  if (has_png()) endings.push_back(".png");
  if (endings.empty()) endings.push_back(".pfm");
  std::vector<fs::path> files;
  for (const std::string& ending : endings) {
    files.push_back(folder / ("paper1_" + contender.name + ending));
    write_image(contender.image, files.back());
  }
  return files;
}

void print_table(const SceneRecord& scene, const fs::path& folder) {
  std::printf("%-6s %9s %11s %15s %8s  %s\n", "", "wall s", "iterations", "relative error", "to vcm", "files");
  const ContenderRecord* vcm = baseline_of(scene);
  for (const ContenderRecord& contender : scene.contenders) {
    if (contender.runs.empty()) continue;
    const RunRecord& run = contender.runs.front();
    const auto efficiency = relative_efficiency(contender.courses(), vcm != nullptr ? vcm->courses() : Courses{});
    std::printf("%-6s %9.2f %11llu %15.4f %8.3f ", contender.name.c_str(), run.wall_seconds,
                static_cast<unsigned long long>(run.iterations), last_error(contender.courses()).value_or(0),
                efficiency ? efficiency->value : 0.0);
    for (const fs::path& file : write_pictures(contender, folder)) std::printf(" %s", file.c_str());
    std::printf("\n");
  }
  std::printf(
      "to vcm: efficiency, 1 / (relative error^2 x processor seconds); twice as much is as good as twice the time\n");
}

/// Reads pbrt's files alone, so that the demo is compiled without the reader of glTF.
LoadedScene load(const fs::path& file, ComparisonRequest::Size size, gmis::scene::LightSelection lights) {
  Diagnostics diagnostics;
  SceneDescription description = read_pbrt_scene(file, diagnostics, {});
  if (size) {
    description.film.width = (*size)[0];
    description.film.height = (*size)[1];
  }
  LoadedScene loaded;
  loaded.built = build_scene(description, diagnostics, lights);
  return loaded;
}

int run(const fs::path& folder, double seconds) {
  fs::create_directories(folder);
  ThreadedExecutor executor(0);
  ComparisonRequest request;
  request.load = load;
  request.scenes = {"paper1"};
  request.size = {{256, 256}};
  request.contenders = {contender_of("gmis"), contender_of("vcm")};
  request.cpu_seconds = seconds * executor.thread_count();
  request.seeds = 1;
  request.folder = folder;
  request.interrupted = &interrupt_flag();
  request.say = [](const std::string&) {};
  std::printf("paper1, 256x256 pixels: about %g s for each integrator, in turns, on %d threads\n", seconds,
              executor.thread_count());
  std::fflush(stdout);
  const Comparison comparison = compare(request, executor);
  if (comparison.scenes.empty()) return 0;
  print_table(comparison.scenes.front(), folder);
  write_whole(html_of(comparison, folder), folder / "report.html");
  std::printf("the pictures side by side, and how the error fell: %s\n", (folder / "report.html").c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 2 ? std::atof(argv[2]) : 6;
  if (argc > 3 || !(seconds > 0)) {
    std::fprintf(stderr, "gmis-demo [FOLDER [SECONDS]]: renders paper1 into FOLDER (out/demo), for 6 s with each\n");
    return 2;
  }
  try {
    return run(argc > 1 ? argv[1] : "out/demo", seconds);
  } catch (const InputError& error) {
    std::fprintf(stderr, "gmis-demo: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gmis-demo: %s\n", error.what());
    return 1;
  }
}
