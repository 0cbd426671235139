// gmis-demo: one scene, the same time for gmis and for vcm, and what each made of it.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "support/image/formats.hpp"
#include "support/progress_bar.hpp"
#include "support/scene_files.hpp"
#include "support/session.hpp"

namespace {

using namespace gmis::tools;
namespace fs = std::filesystem;

struct Entry {
  std::string name;
  RenderResult result;
  std::vector<fs::path> files;

  [[nodiscard]] double efficiency() const { return 1 / (result.estimate.variance * result.wall_seconds); }
};

Entry render_for(double seconds, IntegratorChoice integrator, const BuiltScene& scene, ThreadedExecutor& executor,
                 const fs::path& folder) {
  Options options;
  options.integrator = integrator;
  RenderRequest request = request_of(options, scene);
  request.budget.seconds = seconds;
  request.interrupted = &interrupt_flag();
  ProgressBar bar(request, true);
  if (bar.is_shown()) request.on_iteration = [&](const Progress& progress) { bar.show(progress); };
  Entry entry{name_of(integrator), render(scene, request, executor), {}};
  bar.finish();
  std::vector<std::string> endings;
  if (has_exr()) endings.push_back(".exr");
  if (has_png()) endings.push_back(".png");
  if (endings.empty()) endings.push_back(".pfm");
  for (const std::string& ending : endings) {
    entry.files.push_back(folder / ("paper1_" + entry.name + ending));
    write_image(entry.result.image, entry.files.back());
  }
  return entry;
}

void print_table(const std::vector<Entry>& entries) {
  const Entry& vcm = entries.back();
  std::printf("%-6s %9s %11s %15s %12s %8s  %s\n", "", "seconds", "iterations", "relative error", "efficiency",
              "to vcm", "files");
  for (const Entry& entry : entries) {
    std::printf("%-6s %9.2f %11u %15.4f %12.4g %8.3f ", entry.name.c_str(), entry.result.wall_seconds,
                entry.result.iterations, entry.result.estimate.relative_error, entry.efficiency(),
                entry.efficiency() / vcm.efficiency());
    for (const fs::path& file : entry.files) std::printf(" %s", file.c_str());
    std::printf("\n");
  }
  std::printf("efficiency = 1 / (variance of the image x seconds); twice as much is as good as twice the time\n");
}

int run(const fs::path& folder, double seconds) {
  fs::create_directories(folder);
  const LoadedScene loaded = load_scene(find_scene("paper1"), std::array{256, 256});
  ThreadedExecutor executor(0);
  std::printf("paper1: %s\n256x256 pixels, %g s for each integrator on %d threads\n\n", loaded.built->summary().c_str(),
              seconds, executor.thread_count());
  std::fflush(stdout);
  std::vector<Entry> entries;
  for (const IntegratorChoice integrator : {IntegratorChoice::gmis, IntegratorChoice::vcm})
    entries.push_back(render_for(seconds, integrator, *loaded.built, executor, folder));
  print_table(entries);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 2 ? std::atof(argv[2]) : 25;
  if (argc > 3 || !(seconds > 0)) {
    std::fprintf(stderr, "gmis-demo [FOLDER [SECONDS]]: renders paper1 into FOLDER (out/demo), for 25 s with each\n");
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
