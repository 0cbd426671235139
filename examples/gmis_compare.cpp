// gmis-compare: what accuracy costs in time with each integrator, as a report.
// docs/accuracy-and-time.md tells how to read it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "support/report/comparison.hpp"
#include "support/report/html_report.hpp"
#include "support/report/plot.hpp"
#include "support/report/tables.hpp"
#include "support/whole_file.hpp"

namespace {

using namespace gmis::tools;

struct RawOptions {
  std::vector<std::string> integrators{"pt", "bpt", "vcm", "gmis"};
  std::vector<std::string> reference_integrators{"bpt"};
  std::string size, radius, figure, seed;
  double seconds = 0, error = 0, reference_seconds = 0;
};

void declare(CLI::App& app, ComparisonRequest& request, RawOptions& raw) {
  app.add_option("scenes", request.scenes, ".pbrt, .gltf or .glb files, or names of built-in scenes")->required();
  app.add_option("--integrators", raw.integrators, "Names with commas between; gmis/SPLIT for a way to split")
      ->delimiter(',');
  app.add_option("--time", raw.seconds,
                 "Processor seconds for every integrator and seed (10, if --error is not given)");
  app.add_option("--error", raw.error, "Stop a run when its error against the reference has fallen to this value");
  app.add_option("--seeds", request.seeds, "Runs of every integrator (3)")->check(CLI::Range(1, 1000));
  app.add_option("--size", raw.size, "WIDTHxHEIGHT in pixels (the film's)");
  app.add_option("--seed", raw.seed, "The first seed (0)");
  app.add_option("--threads", request.settings.threads,
                 "Threads (all cores); no more than there are processors are used")
      ->check(CLI::Range(1, 4096));
  app.add_option("--max-depth", request.settings.max_depth, "Most segments of a path (16)");
  app.add_option("--radius", raw.radius,
                 "Merging radius in pixel widths, or with the suffix u in scene units (0.4 pixel widths)");
  app.add_option("--alpha", request.settings.alpha, "The radius shrinks as i^((alpha-1)/2) (2/3)");
  app.add_option("--light-paths", request.settings.light_paths, "Light trees per pixel (1)");
  app.add_option("--reference", request.reference,
                 "The true image, .exr or .pfm (made by a long run and kept in the folder of --out)");
  app.add_option("--reference-integrator", raw.reference_integrators,
                 "Integrator of the references (bpt): one for all scenes, or one for each with commas between")
      ->delimiter(',');
  app.add_option("--reference-time", raw.reference_seconds, "Processor seconds for making it (10 times --time)");
  app.add_option("--out", request.folder, "Folder for report.html, report.md and the logs (out/compare)");
  app.add_option("--figure", raw.figure, "Also the curves of all scenes as one picture, .svg; needs gnuplot");
}

void check(const CLI::App& app, ComparisonRequest& request, const RawOptions& raw) {
  for (const std::string& name : raw.integrators) request.contenders.push_back(contender_of(name));
  if (!raw.size.empty()) request.size = size_of(raw.size);
  if (!raw.radius.empty()) request.settings.radius = radius_of(raw.radius);
  if (!raw.seed.empty()) request.settings.seed = seed_of(raw.seed);
  require_in_range(request.settings);
  const auto above_zero = [&](const char* option, double value) {
    const bool is_given = app.count(option) > 0;
    if (is_given) require_above_zero(option, value);
    return is_given;
  };
  if (above_zero("--time", raw.seconds)) request.cpu_seconds = raw.seconds;
  if (above_zero("--error", raw.error)) request.error = raw.error;
  if (!request.cpu_seconds && !request.error) request.cpu_seconds = 10;
  constexpr double reference_share = 10, without_time = 100;
  request.reference_seconds = above_zero("--reference-time", raw.reference_seconds)
                                  ? raw.reference_seconds
                                  : request.cpu_seconds.value_or(without_time / reference_share) * reference_share;
  request.reference_integrators.clear();
  for (const std::string& name : raw.reference_integrators)
    request.reference_integrators.push_back(integrator_of(name, "--reference-integrator"));
  if (request.reference_integrators.size() > 1 && request.reference_integrators.size() != request.scenes.size())
    throw InputError("--reference-integrator must name one integrator, or one for each scene");
  if (!request.reference.empty() && request.scenes.size() > 1)
    throw InputError("--reference is for one scene: name one, or leave the option out");
}

void write_report(const Comparison& comparison, const std::filesystem::path& folder) {
  write_whole(html_of(comparison, folder), folder / "report.html");
  write_whole(markdown_of(comparison), folder / "report.md");
}

int run(ComparisonRequest request, const std::string& figure) {
  std::error_code error;
  std::filesystem::create_directories(request.folder, error);
  if (!std::filesystem::is_directory(request.folder, error))
    throw InputError("--out " + request.folder.string() + ": this folder cannot be created");
  try {
    require_writable(request.folder / "report.html");
  } catch (const InputError& failure) {
    throw InputError(std::string("--out: ") + failure.what());
  }
  if (!has_gnuplot()) std::fprintf(stderr, "gmis-compare: gnuplot was not found: the report will have no curves\n");
  ThreadedExecutor executor(request.settings.threads);
  request.load = [](const std::filesystem::path& file, ComparisonRequest::Size size,
                    gmis::scene::LightSelection lights) { return load_scene(file, size, Strictness::strict, lights); };
  request.interrupted = &interrupt_flag();
  request.say = [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  };
  request.on_scene = [&](const Comparison& comparison) {
    write_report(comparison, request.folder);
    std::printf("\n%s\n", text_of(table_of(comparison.scenes.back())).c_str());
    std::fflush(stdout);
  };
  if (!figure.empty()) {
    if (!has_gnuplot()) throw InputError("--figure " + figure + " is drawn by gnuplot, which is missing");
    require_writable(figure);
  }
  const Comparison comparison = compare(request, executor);
  write_report(comparison, request.folder);
  if (!figure.empty()) {
    const std::string svg = error_figure_svg(comparison.scenes, request.folder);
    if (svg.empty()) throw InputError("--figure " + figure + ": there are no curves to draw");
    write_whole(svg, figure);
  }
  std::printf("%swrote %s\n", comparison.is_whole ? "" : "interrupted; ", (request.folder / "report.html").c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Compares integrators: error over processor time, in turns on one machine.", "gmis-compare");
  app.set_version_flag("--version", GMIS_VERSION);
  ComparisonRequest request;
  request.folder = "out/compare";
  RawOptions raw;
  declare(app, request, raw);
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& success) {
      return app.exit(success);
    } catch (const CLI::ParseError& error) {
      throw InputError(error.what() + std::string("; see --help"));
    }
    check(app, request, raw);
    return run(std::move(request), raw.figure);
  } catch (const InputError& error) {
    std::fprintf(stderr, "gmis-compare: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gmis-compare: %s\n", error.what());
    return 1;
  }
}
