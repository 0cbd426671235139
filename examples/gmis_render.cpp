// gmis-render: from a scene file to a picture. docs/gmis-render.md tells how it is used.
// gmis-render-mpi is the same over many machines (gmis_render_mpi.cpp).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "gmis/core/state_archive.hpp"
#include "gmis/render/rank_gathering.hpp"
#include "gmis/render/run_record.hpp"
#include "support/choices.hpp"
#include "support/denoise.hpp"
#include "support/file_ending.hpp"
#include "support/first_hit_layers.hpp"
#include "support/hidden_sky.hpp"
#include "support/instruction_set.hpp"
#include "support/load_scene.hpp"
#include "support/output.hpp"
#include "support/plan_text.hpp"
#include "support/progress_bar.hpp"
#include "support/read_scene.hpp"
#include "support/render_program.hpp"
#include "support/replay_text.hpp"
#include "support/scene_files.hpp"
#include "support/session.hpp"
#include "support/tev.hpp"
#include "support/whole_file.hpp"

namespace {

using namespace gmis::tools;

enum ExitCode : int { done = 0, failed = 1, bad_input = 2 };

/// Whether two paths lead to one file, which need not exist; a device may have several uses.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(a, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) return false;
  const auto whole = [&](const fs::path& file) {
    return fs::weakly_canonical(fs::absolute(target_of(file), error), error);
  };
  return whole(a) == whole(b) || fs::equivalent(a, b, error);
}

/// Throws when two options write one file, which they need not name, or one writes what is read.
void require_different_files(const Options& options, const std::vector<std::filesystem::path>& scene_files) {
  using File = std::pair<std::string, std::filesystem::path>;
  std::vector<File> files;
  for (const auto& output : options.outputs) files.emplace_back("--out", output);
  files.emplace_back("--stats", options.statistics_file);
  files.emplace_back("--log", options.log_file);
  files.emplace_back("--checkpoint", options.checkpoint_file);
  for (const auto& output : options.outputs) {
    if (options.halves) files.emplace_back("--halves", file_beside(output, "_a"));
    if (options.halves) files.emplace_back("--halves", file_beside(output, "_b"));
    if (options.denoise) files.emplace_back("--denoise", file_beside(output, "_denoised"));
  }
  const auto is_nothing = [](const File& one) { return one.second.empty(); };
  std::erase_if(files, is_nothing);
  const std::size_t output_count = files.size();
  for (const auto& file : scene_files) files.emplace_back("the scene's", file);
  files.emplace_back("--reference", options.reference_file);
  files.emplace_back("--sky", options.load.sky);
  for (const auto& file : options.resume_files) files.emplace_back("--resume", file);
  std::erase_if(files, is_nothing);
  const auto require_different = [](const File& one, const File& other) {
    if (one.first == "--checkpoint" && other.first == "--resume") return;  // the run goes on
    if (is_same_file(one.second, other.second))
      throw InputError(one.first + " " + one.second.string() + " and " + other.first + " " + other.second.string() +
                       " are the same file: give each a name of its own");
  };
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < std::min(i, output_count); ++j) require_different(files[j], files[i]);

  // The files in a folder differ from each other.
  std::vector<File> in_folders;
  if (options.class_images && !options.outputs.empty())
    for (const auto& file : files_of_classes(class_folder(options.outputs[0])))
      in_folders.emplace_back("--aov classes", file);
  if (!options.techniques_folder.empty())
    for (const File& one : files)
      if (const auto name = one.second.filename(); may_be_of_technique(name))
        in_folders.emplace_back("--techniques", options.techniques_folder / name);
  for (const File& one : files)
    for (const File& other : in_folders) require_different(one, other);
}

/// Throws before rendering when the folder of an output or a library for its format is missing.
void check_outputs(const Options& options, const std::filesystem::path& scene_file) {
  if (options.denoise && !has_denoiser())
    throw InputError(
        "--denoise: this program is built without Open Image Denoise: install it and rebuild, or give a denoiser "
        "what --aov layers writes");
  for (const auto& output : options.outputs) require_writable_format(output);
  const auto require_folder = [](const std::filesystem::path& file, const char* option) {
    if (file.empty()) return;
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder))
      throw InputError(file.string() + ": the folder of this " + option + " file does not exist: create it first");
  };
  for (const auto& output : options.outputs) require_folder(output, "--out");
  require_folder(options.statistics_file, "--stats");
  require_folder(options.log_file, "--log");
  require_folder(options.checkpoint_file, "--checkpoint");
  require_different_files(options, {scene_file});
  for (const auto& output : options.outputs) require_writable(output);
  if (!options.statistics_file.empty()) require_writable(options.statistics_file);
  if (!options.log_file.empty()) require_writable(options.log_file);
  if (!options.checkpoint_file.empty()) require_writable(options.checkpoint_file);
  if (options.techniques_folder.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(options.techniques_folder, error);
  if (!std::filesystem::is_directory(options.techniques_folder))
    throw InputError(options.techniques_folder.string() + ": this folder of --techniques cannot be created");
}

std::filesystem::path scene_file_of(const Options& options) {
  std::filesystem::path file = find_scene(options.scene);
  if (options.load.seconds && !is_gltf(file))
    throw InputError("--at needs a .gltf or .glb file: " + file.string() + " has no animations");
  return file;
}

/// The film's file name, in the current folder; as .pfm when its own format cannot be written.
std::filesystem::path default_output(const BuiltScene& scene, bool is_quiet) {
  std::filesystem::path file = std::filesystem::path(scene.film_file_name()).filename();
  try {
    require_writable_format(file);
  } catch (const InputError& error) {
    file.replace_extension(".pfm");
    if (!is_quiet) std::fprintf(stderr, "gmis-render: %s; writing %s\n", error.what(), file.c_str());
  }
  require_writable(file);
  return file;
}

/// The run as checkpoints name it: the scene, and choices that the settings do not name.
void identify_run(RenderRequest& request, const LoadedScene& loaded, const Options& options) {
  identify_scene(request, loaded);
  const auto add = [&](const char* name, std::string value) {
    request.scene_properties.emplace_back(name, std::move(value));
  };
  // `gmis` that does not split is `vcm`.
  const bool is_vcm = options.integrator == IntegratorChoice::gmis && options.split == SplitChoice::none;
  add("the integrator", name_of(is_vcm ? IntegratorChoice::vcm : options.integrator));
  if (options.integrator == IntegratorChoice::gmis && !is_vcm) add("the way to split", name_of(options.split));
  add("the choice of lights", name_of(options.lights));
  add("the version", GMIS_VERSION);
}

/// The first failure to write a file. A failure does not keep the other files from being written.
class WriteFailures {
 public:
  void add(const std::string& message) {
    if (first_.empty()) first_ = message;
  }
  /// True when `write` wrote.
  template <class Write>
  bool attempt(const Write& write) {
    try {
      write();
      return true;
    } catch (const OutputError& error) {
      add(error.what());
      return false;
    }
  }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  std::string first_;
};

/// About how many pieces of work an iteration has: rows of pixels and, where light is traced,
/// chunks of 256 light trees.
std::size_t pieces_of_iteration(const RenderRequest& request, const BuiltScene& scene) {
  const glm::ivec2 size = scene.scene().camera().resolution();
  const gmis::PixelBounds crop = gmis::crop_of(request, size);
  const double trees = request.settings.counts.light_paths * size.x * size.y;
  return static_cast<std::size_t>(std::max(0, crop.upper.y - crop.lower.y)) + static_cast<std::size_t>(trees / 256);
}

/// A line in the file for every point, as it is made; the file is whole at every moment.
std::function<void(const gmis::ConvergencePoint&)> log_to(const std::filesystem::path& file, WriteFailures& failures) {
  const auto text = std::make_shared<std::string>(gmis::convergence_csv_header() + "\n");
  write_whole(*text, file);
  return [text, file, &failures](const gmis::ConvergencePoint& point) {
    *text += gmis::convergence_csv_row(point) + "\n";
    failures.attempt([&] { write_whole(*text, file); });
  };
}

void print_summary(const RenderResult& result, const RenderRequest& request, const gmis::Plan& plan,
                   const std::vector<std::filesystem::path>& written, const std::optional<gmis::ImageError>& error) {
  if (result.joined_seeds.empty())
    std::printf("%u iterations in %.2f s (stopped by %s), mean %.6g", result.iterations, result.wall_seconds,
                gmis::name_of(result.stopped_by), result.estimate.mean);
  else
    std::printf("%u iterations of %zu runs in %.2f s, mean %.6g", result.iterations, result.joined_seeds.size(),
                result.wall_seconds, result.estimate.mean);
  if (result.error && result.error->relative_error > 0) {
    std::printf(", relative error %.4f", result.error->relative_error);
    if (result.error->is_calibrated())
      std::printf(" (95 %%: %.4f to %.4f)", result.error->interval.lower, result.error->interval.upper);
  }
  std::printf("\n");
  if (const std::string parts = noise_and_bias(result); !parts.empty()) std::printf("%s\n", parts.c_str());
  std::fputs(caution_of(result, request, plan).c_str(), stdout);
  std::fputs(text_of(result.prices).c_str(), stdout);
  if (error)
    std::printf("against the reference: relMSE %.4g (%.4g without the worst 0.1 %% of the pixels), RMSE %.4g\n",
                error->relmse, error->relmse_trimmed, error->rmse);
  for (const ClassImage& one : result.classes.classes)
    std::printf("%-10s  mean %-10.4g  cost %4.1f %%\n", std::string(gmis::name_of(one.path_class)).c_str(),
                mean_of(one.image), 100 * one.cost);
  for (const LightImage& one : result.by_light)
    std::printf("%-10s  mean %.4g\n", name_of_light(one.group).c_str(), mean_of(one.image));
  for (const auto& output : written) std::printf("wrote %s\n", output.c_str());
}

/// One line: how many samples were rejected, and the --replay option for the first of them.
void print_distrust(const RenderResult& result, double largest_share) {
  const gmis::Counters& counters = result.counters;
  std::fprintf(
      stderr,
      "gmis-render: the picture cannot be trusted: %llu samples were rejected for %llu contributions (%llu not "
      "finite, %llu negative, %llu of density zero), and the limit is %g %%",
      static_cast<unsigned long long>(counters.rejected()), static_cast<unsigned long long>(counters.contributions),
      static_cast<unsigned long long>(counters.rejected_non_finite),
      static_cast<unsigned long long>(counters.rejected_negative),
      static_cast<unsigned long long>(counters.rejected_zero_pdf), 100.0 * largest_share);
  if (!result.rejected_paths.empty())
    std::fprintf(stderr, "; --replay %s shows the first path", text_of(result.rejected_paths.front().path).c_str());
  std::fprintf(stderr, "\n");
}

void write_statistics(const RenderResult& result, const RunFacts& facts) {
  write_whole(statistics_json(result, facts), facts.options->statistics_file);
}

int print_replay(const RenderRequest& request, const PathChoice& choice, const BuiltScene& scene, int threads) {
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  const gmis::PathName path = path_of(choice, request, resolution);
  ThreadedExecutor executor(threads);
  std::fputs(replay_text(replay(scene, request, executor, path), request, resolution).c_str(), stdout);
  return done;
}

/// The notes in an .exr or .png on how it was made.
std::vector<std::pair<std::string, std::string>> notes_of(const Options& options, const RenderResult& result,
                                                          const std::string& plan) {
  std::vector<std::pair<std::string, std::string>> notes{{"gmis:version", GMIS_VERSION},
                                                         {"gmis:commandLine", options.command_line},
                                                         {"gmis:seed", std::to_string(options.seed)},
                                                         {"gmis:iterations", std::to_string(result.iterations)},
                                                         {"gmis:plan", plan},
                                                         {"gmis:radius", std::to_string(result.radius)}};
  if (result.error) notes.emplace_back("gmis:relativeError", std::to_string(result.error->relative_error));
  return notes;
}

int print_check(const std::filesystem::path& file, const LoadOptions& load, bool is_quiet) {
  const Diagnostics diagnostics = check_scene_file(file, load);
  if (!is_quiet)
    for (const Diagnostic& diagnostic : diagnostics.all()) std::printf("%s\n", diagnostic.to_string().c_str());
  const std::size_t errors = diagnostics.error_count();
  if (errors == 0) {
    const std::size_t said = diagnostics.all().size();
    if (!is_quiet && said == 0) std::printf("%s: all of it is understood\n", file.c_str());
    if (!is_quiet && said > 0) std::printf("%s: can be rendered; notes and warnings above: %zu\n", file.c_str(), said);
    return done;
  }
  std::fprintf(stderr, "gmis-render: %s cannot be rendered: %zu %s\n", file.c_str(), errors,
               errors == 1 ? "error" : "errors");
  return bad_input;
}

/// Calls `load` on every rank. If any of them throws, all throw the message of the first rank that
/// failed, so that no rank waits for another.
template <class Load>
void on_all_ranks(const gmis::RanksRef& ranks, const Load& load) {
  if (ranks.count() == 1) return load();
  std::string failure;
  try {
    load();
  } catch (const std::exception& error) {
    failure = error.what();
  }
  std::string first;
  gmis::detail::for_each_rank(ranks, std::as_bytes(std::span(failure)),
                              [&](std::size_t rank, std::span<const std::byte> said) {
                                if (first.empty() && !said.empty())
                                  first = (rank > 0 ? "rank " + std::to_string(rank) + ": " : "") +
                                          std::string(reinterpret_cast<const char*>(said.data()), said.size());
                              });
  first = gmis::detail::text_of_first(ranks, std::move(first));
  if (!first.empty()) throw InputError(first);
}

/// Arrays of pixels come and go while a picture is rendered. To ask the system for their memory
/// each time, page by page, takes longer than to use it.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

int run(Options options, const gmis::RanksRef& ranks) {
  if (ranks.count() > 1 && (options.check || options.replay || options.resume_files.size() > 1 || options.part))
    throw InputError("--check, --replay, --iterations FIRST..LAST/OF and joining runs need a single rank");
  if (options.list_scenes) {
    for (const std::string& name : built_in_scene_names())
      std::printf("%-10s  %s\n", name.c_str(), line_of_scene(name).c_str());
    return done;
  }
  if (options.check) return print_check(scene_file_of(options), options.load, options.quiet);
  const bool is_first = ranks.is_first();
  LoadedScene loaded;
  RenderRequest request;
  on_all_ranks(ranks, [&] {
    const std::filesystem::path file = scene_file_of(options);
    if (!options.replay && is_first) check_outputs(options, file);
    loaded = load_scene(file, options.size, options.lenient ? Strictness::lenient : Strictness::strict, options.lights,
                        options.load);
    request = request_of(options, *loaded.built);
  });
  const BuiltScene& scene = *loaded.built;
  if (!options.quiet && is_first)
    for (const Diagnostic& diagnostic : loaded.diagnostics)
      std::fprintf(stderr, "%s\n", diagnostic.to_string().c_str());
  request.ranks = ranks;
  if (options.replay) return print_replay(request, *options.replay, scene, options.threads);
  std::optional<Image> reference;
  if (!options.reference_file.empty() && is_first)
    reference = read_reference(options.reference_file, request, scene.scene().camera().resolution());

  on_all_ranks(ranks, [&] {
    if (!is_first) return;
    if (options.outputs.empty()) options.outputs.push_back(default_output(scene, options.quiet));
    require_different_files(options, loaded.files);
  });

  const auto has_layers = [](const std::filesystem::path& file) { return ending_of(file) == ".exr"; };
  if (options.layers && is_first && !options.quiet &&
      std::none_of(options.outputs.begin(), options.outputs.end(), has_layers))
    std::fprintf(stderr, "gmis-render: --aov layers writes nothing: only an .exr has layers, and no --out names one\n");
  if (options.class_images && is_first) {
    const std::filesystem::path folder = class_folder(options.outputs[0]);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (!std::filesystem::is_directory(folder))
      throw InputError(folder.string() + ": this folder of --aov classes cannot be created");
  }

  ThreadedExecutor executor(options.threads);
  if (!ThreadedExecutor::has_threads && options.threads != 1 && !options.quiet && is_first)
    std::fprintf(stderr, "gmis-render: built without oneTBB: one thread is used\n");
  const gmis::Plan plan = plan_for_scene(scene, request.settings);
  if (options.explain && is_first)
    std::fputs(explain(options, request, plan, scene, executor.thread_count()).c_str(), stdout);
  if (!options.quiet && is_first && plan.classes.is_empty() && !plan.occurring.is_empty())
    std::fprintf(stderr,
                 "gmis-render: --effects keeps no path that this scene has (--explain names them): the picture will be "
                 "black\n");

  // No iteration would ever find anything, so that --error alone would never end the run.
  if (plan.classes.is_empty() && !request.budget.iterations && !request.budget.seconds) request.budget.iterations = 1;

  WriteFailures failures;
  request.interrupt = &interrupt_flag();
  if (reference) request.reference = reference->rgb;
  const bool is_kept = !options.checkpoint_file.empty() || !options.resume_files.empty();
  request.intervals = !options.quiet || !options.log_file.empty() || !options.statistics_file.empty() || is_kept ||
                      options.layers;  // one layer is the variance
  if (is_kept || ranks.count() > 1) identify_run(request, loaded, options);
  on_all_ranks(ranks, [&] {
    if (is_first)
      for (const auto& file : options.resume_files) request.resume.push_back(bytes_of(file));
  });
  request.resume_files = options.resume_files;
  if (!options.resume_files.empty()) {
    request.resume.resize(options.resume_files.size());
    request.resume[0].resize(ranks.of_first(request.resume[0].size()));
    ranks.broadcast(request.resume[0]);
  }
  if (!options.checkpoint_file.empty())
    request.on_checkpoint = [&](std::span<const std::byte> state) {
      failures.attempt([&] {
        write_whole(std::string(reinterpret_cast<const char*>(state.data()), state.size()), options.checkpoint_file);
      });
    };
  ImageExtras extras;
  const auto expose = [&](const Image& image) {
    extras.exposure = static_cast<float>(std::exp2(options.exposure.value_or(automatic_exposure(image))));
  };
  extras.tone = options.tone;
  if (!options.log_file.empty() && is_first) request.on_log = log_to(options.log_file, failures);
  request.seconds_between_pictures = options.write_every;
  std::optional<TevViewer> viewer;
  if (!options.tev_address.empty() && is_first) {
    viewer.emplace(options.tev_address, "gmis-render");
    if (!options.quiet && !viewer->warning().empty())
      std::fprintf(stderr, "gmis-render: warning: %s\n", viewer->warning().c_str());
    request.seconds_between_pictures = std::min(options.write_every, 1.0);
  }
  auto last_written = std::chrono::steady_clock::now();
  request.on_picture = [&](const gmis::Picture& picture) {
    const Image image = image_of(picture);
    if (viewer) {
      viewer->show(image);
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - last_written;
      if (passed.count() < options.write_every) return;
      last_written = std::chrono::steady_clock::now();
    }
    expose(image);
    WriteFailures on_the_way;  // only the final picture must be written
    for (const auto& output : options.outputs) on_the_way.attempt([&] { write_image(image, output, extras); });
  };
  ProgressBar bar(request.budget, pieces_of_iteration(request, scene), !options.quiet && is_first);
  if (bar.is_shown()) {
    request.on_iteration = [&](const gmis::RunState& progress) { bar.show(progress); };
    executor.report_to([&](std::size_t done) { bar.show_piece(done); });
  }
  if (options.explain)
    request.on_forecast = [&](const gmis::PriceTable& prices) {
      bar.finish();
      std::fputs(explain_forecast(prices).c_str(), stdout);
      std::fflush(stdout);
    };
  keep_freed_memory();
  const RenderResult result = render(scene, request, executor);
  if (!is_first) return done;
  executor.report_to({});
  bar.finish();
  if (viewer) viewer->show(result.image);
  if (!result.joined_seeds.empty() && request.on_log)  // runs that are joined have made their points long ago
    for (const gmis::ConvergencePoint& point : result.log) request.on_log(point);
  if (options.explain && result.choice) std::fputs(explain_choice(*result.choice, result.counters).c_str(), stdout);
  if (options.explain) std::fputs(explain_lights(result.lights).c_str(), stdout);

  RunFacts facts;
  facts.options = &options;
  facts.plan = plan_of(request, result.counts);
  facts.scene_plan = plan;
  facts.threads = executor.thread_count();
  facts.read_seconds = loaded.read_seconds;
  facts.build_seconds = loaded.build_seconds;
  if (reference) {
    facts.error =
        gmis::image_error(std::span<const float>(result.image.rgb), std::span<const float>(reference->rgb), 3);
    facts.ratio_of_means = mean_of(result.image) / mean_of(*reference);
  }

  expose(result.image);
  extras.notes = notes_of(options, result, facts.plan);
  extras.notes.emplace_back("gmis:exposure", std::to_string(std::log2(extras.exposure)));
  std::vector<ImageLayer> first_hits;
  if (options.layers || options.denoise) first_hits = first_hit_layers(scene, request.crop, executor);
  if (options.layers) extras.layers = first_hits;
  for (ImageLayer& layer : layers_of(result, options)) extras.layers.push_back(std::move(layer));
  std::vector<std::filesystem::path> written;
  for (const auto& output : options.outputs)
    if (failures.attempt([&] { write_output(result, output, options.halves, extras); })) written.push_back(output);
  if (options.denoise)
    failures.attempt([&] {
      extras.layers.clear();
      const Image smooth = denoised(result.image, first_hits[0].image, first_hits[1].image);
      for (const auto& output : options.outputs) write_image(smooth, file_beside(output, "_denoised"), extras);
    });
  if (!options.techniques_folder.empty())
    failures.attempt([&] { write_techniques(result, options.techniques_folder); });
  if (options.class_images) failures.attempt([&] { write_classes(result, class_folder(options.outputs[0])); });
  if (!options.statistics_file.empty()) failures.attempt([&] { write_statistics(result, facts); });
  if (!options.quiet) print_summary(result, request, plan, written, facts.error);
  const auto is_png = [](const std::filesystem::path& file) { return ending_of(file) == ".png"; };
  if (!options.quiet && !options.exposure && std::any_of(written.begin(), written.end(), is_png))
    std::printf("exposure of .png: %.2f, chosen from the picture (see --exposure)\n",
                static_cast<double>(std::log2(extras.exposure)));
  const auto is_black = [](const Image& image) {
    return std::all_of(image.rgb.begin(), image.rgb.end(), [](float value) { return value == 0; });
  };
  if (!options.quiet && is_black(result.image) && sky_is_hidden(scene))
    std::fprintf(
        stderr,
        "gmis-render: the picture is black: surfaces enclose the camera, and no light was found inside; move the "
        "camera, or put a light inside\n");
  if (options.list_rejected)
    std::fputs(rejected_text(result.rejected_paths, scene.scene().camera().resolution()).c_str(), stdout);
  if (!failures.first().empty()) std::fprintf(stderr, "gmis-render: %s\n", failures.first().c_str());
  if (!result.is_trustworthy) print_distrust(result, request.rejection_limit.share);
  return failures.first().empty() && result.is_trustworthy ? done : failed;
}

}  // namespace

int gmis::tools::render_program(int argc, char** argv, const RanksRef& ranks) {
  const auto fail = [&](int code, const char* message) {
    std::fprintf(stderr, "gmis-render: %s\n", message);
    return code;
  };
  try {
    if (!processor_has_instruction_set())
      throw std::runtime_error(
          "compiled for " + std::string(instruction_set) +
          ", whose instructions this processor lacks: configure with -DGMIS_ISA=x86-64, or take ./run --isa "
          "x86-64 path gmis-render");
    const std::optional<Options> options = parse_command_line(argc, argv);
    const int code = options ? run(*options, ranks) : done;
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error("standard output cannot be written: check that it has space");
    return code;
  } catch (const InputError& error) {
    return ranks.is_first() ? fail(bad_input, error.what()) : bad_input;
  } catch (const std::bad_alloc&) {
    return fail(
        failed,
        "there is not enough memory: choose a smaller --size or fewer --light-paths, and leave out --techniques");
  } catch (const std::exception& error) {
    return fail(failed, error.what());
  }
}
