#include "support/report/comparison.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>
#include <thread>

#include "gmis/core/state_archive.hpp"
#include "gmis/render/run_identity.hpp"
#include "gmis/result/image_error.hpp"
#include "support/diagnostics.hpp"
#include "support/image/formats.hpp"
#include "support/image/image.hpp"
#include "support/progressive_render.hpp"
#include "support/report/false_colour.hpp"
#include "support/report/html_report.hpp"
#include "support/report/tables.hpp"
#include "support/scene_files.hpp"
#include "support/whole_file.hpp"

namespace gmis::tools {

namespace {

bool is_interrupted(const ComparisonRequest& request) {
  return request.interrupted != nullptr && request.interrupted->load();
}

/// A scene, loaded once for every way in which integrators choose lights.
class LoadedScenes {
 public:
  LoadedScenes(const ComparisonRequest& request, const std::string& name)
      : request_(&request), file_(find_scene(name)) {}

  [[nodiscard]] const LoadedScene& for_integrator(IntegratorChoice integrator) {
    const scene::LightSelection lights = default_lights(integrator);
    LoadedScene& loaded = loaded_[lights];
    if (!loaded.built) loaded = request_->load(file_, request_->size, lights);
    return loaded;
  }

 private:
  const ComparisonRequest* request_;
  std::filesystem::path file_;
  std::map<scene::LightSelection, LoadedScene> loaded_;
};

/// References have a seed that no run has.
constexpr std::uint64_t reference_seed = 0x5EED0FF5E7ULL;

/// The request of gmis-render with this integrator, without an end.
RenderRequest render_request(const ComparisonRequest& request, const BuiltScene& scene, IntegratorChoice integrator,
                             SplitChoice split) {
  Options options = request.settings;
  options.integrator = integrator;
  options.emission = default_emission(integrator);
  options.split = integrator == IntegratorChoice::gmis ? split : SplitChoice::none;
  options.iterations.reset();
  options.seconds.reset();
  options.relative_error.reset();
  RenderRequest result = request_of(options, scene);
  result.intervals = true;
  return result;
}

std::string file_name_of(const std::string& name) {
  std::string result = std::filesystem::path(name).stem().string();
  for (char& c : result)
    if (!(std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')) c = '_';
  return result;
}

/// The text as a shell reads it for one word.
std::string in_shell(const std::string& text) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_./+-=:,@%").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), is_plain)) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// A command line of gmis-render that gives the same picture. `expected_iterations` are those that
/// the run's pilot chose for; 0: there was none.
std::string command_of(const ComparisonRequest& request, const std::string& scene,
                       const ComparisonRequest::Contender& contender, glm::ivec2 size, const RunRecord& run,
                       std::uint32_t expected_iterations) {
  const Options defaults;
  const Options& options = request.settings;
  const IntegratorChoice integrator = contender.integrator;
  std::string text = "gmis-render " + in_shell(scene) + " --integrator " + name_of(integrator);
  if (integrator == IntegratorChoice::gmis) text += std::string(" --split ") + name_of(contender.split);
  text += " --size " + std::to_string(size.x) + "x" + std::to_string(size.y) + " --max-depth " +
          std::to_string(options.max_depth) + " --seed " + std::to_string(run.seed) + " --iterations " +
          std::to_string(run.iterations);
  if (expected_iterations > 0 && expected_iterations != run.iterations)
    text += " --expected-iterations " + std::to_string(expected_iterations);
  if (merges(integrator) && options.radius) text += " --radius " + argument_of(*options.radius);
  if (merges(integrator) && options.alpha != defaults.alpha) text += " --alpha " + argument_of(options.alpha);
  if (traces_light(integrator) && options.light_paths) text += " --light-paths " + argument_of(*options.light_paths);
  return text;
}

/// The picture in the folder, for viewers of such files: its name there.
std::string kept(const Image& image, const std::string& stem, const std::filesystem::path& folder) {
  if (image.rgb.empty()) return {};
  const std::string name = stem + (has_exr() ? ".exr" : ".pfm");
  write_image(image, folder / name);
  return name;
}

struct Reference {
  Image image;
  std::string origin;
  std::optional<double> error;
};

/// Digest of all that the picture depends on: the content of the scene's files, the settings.
std::string digest_of_run(RenderRequest request, const LoadedScene& loaded) {
  identify_scene(request, loaded);
  RunIdentity identity =
      identity_of(request, loaded.built->scene().camera().resolution(), SceneSpectrum::length(), sizeof(float));
  StateWriter writer;
  writer(identity);
  return digest_text(writer.bytes());
}

/// From the folder when the same was made before; else by a long run, which is then kept there.
std::optional<Reference> make_reference(const ComparisonRequest& request, const LoadedScene& loaded,
                                        const std::string& name, IntegratorChoice integrator,
                                        ThreadedExecutor& executor) {
  const BuiltScene& scene = *loaded.built;
  RenderRequest render = render_request(request, scene, integrator, SplitChoice::local);
  render.settings.seed = reference_seed;
  const bool is_merging = merges(integrator);
  if (is_merging) {  // a sixteenth of the bias
    render.settings.counts.radius_factor /= 4;
    for (SampleCounts& candidate : render.candidates) candidate.radius_factor /= 4;
  }
  const glm::ivec2 size = scene.scene().camera().resolution();
  const std::string what = std::string(name_of(integrator)) +
                           (is_merging ? " (biased, with a quarter of the radius)" : " (unbiased)") +
                           ", another seed, " + three_digits(request.reference_seconds) + " processor seconds";
  const std::string stem = "reference_" + name + "_" + std::to_string(size.x) + "x" + std::to_string(size.y) +
                           "_depth" + std::to_string(render.settings.max_depth) + "_" + name_of(integrator) + "_" +
                           three_digits(request.reference_seconds) + "s_" + digest_of_run(render, loaded);
  const std::filesystem::path image_file = request.folder / (stem + ".pfm"),
                              error_file = request.folder / (stem + ".txt");
  Reference reference;
  if (double error = 0; std::filesystem::exists(image_file) && std::ifstream(error_file) >> error) {
    reference.image = read_image(image_file);
    reference.error = error;
    reference.origin = what + ", from an earlier run; its own relative error is " + percentage(error);
    return reference;
  }
  request.say(name + ": making a reference with " + what);
  ProgressiveRender rendering(scene, render);
  while (rendering.cpu_seconds() < request.reference_seconds) {
    if (is_interrupted(request)) return {};
    if (!rendering.advance(executor)) return {};
  }
  reference.image = rendering.image();
  if (const auto error = rendering.error()) reference.error = error->relative_error;
  reference.origin = what + "; its own relative error is " + percentage(reference.error.value_or(0));
  write_image(reference.image, image_file);
  write_whole(std::to_string(reference.error.value_or(0)) + "\n", error_file);
  return reference;
}

/// The standard deviation of every value over √(value² + 0.01).
Image estimated_pixel_error(const Film<SceneSpectrum>& film) {
  Image error(film.resolution().x, film.resolution().y);
  for (std::size_t pixel = 0; pixel < film.pixel_count(); ++pixel)
    for (int c = 0; c < 3; ++c) {
      const double value = film.mean(pixel, c);
      error.rgb[3 * pixel + static_cast<std::size_t>(c)] =
          static_cast<float>(std::sqrt(film.variance_of_mean(pixel, c) / (value * value + relative_error_floor)));
    }
  return error;
}

/// One integrator with one seed, on its way.
struct Runner {
  Runner(const BuiltScene& scene, const RenderRequest& request, const Image& scene_reference,
         ContenderRecord& its_record)
      : rendering(scene, request), reference(scene_reference), record(&its_record) {
    if (request.candidates.size() > 1) expected_iterations = request.expected_iterations;
  }
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  ProgressiveRender rendering;
  const Image& reference;  // empty when there is none
  ContenderRecord* record;
  std::uint32_t expected_iterations = 0;  // that a pilot chooses for; 0: there is none
  bool is_done = false;

  [[nodiscard]] bool has_enough(const ComparisonRequest& limits) const {
    if (limits.cpu_seconds && rendering.cpu_seconds() >= *limits.cpu_seconds) return true;
    const auto& points = rendering.log().points();
    return limits.error && points.size() > 2 && points.back().reference_error.value_or(1e9) <= *limits.error &&
           points[points.size() - 2].reference_error.value_or(1e9) <= *limits.error;
  }

  void store(std::uint64_t seed) {
    rendering.finish_log();
    RunRecord run;
    run.seed = seed;
    run.iterations = rendering.progress().iterations;
    run.cpu_seconds = rendering.cpu_seconds();
    run.wall_seconds = rendering.progress().seconds;
    run.points = rendering.log().points();
    if (record->image.rgb.empty()) {
      record->image = rendering.image();
      record->bias = rendering.merging_bias();
      record->pixel_error =
          reference.rgb.empty() ? estimated_pixel_error(rendering.film()) : pixel_error(record->image, reference);
    }
    record->runs.push_back(std::move(run));
  }
};

/// False when it was interrupted; the runs are then as far as they came.
bool run_seed(const ComparisonRequest& request, const std::string& name, LoadedScenes& scenes, SceneRecord& record,
              std::uint64_t seed, ThreadedExecutor& executor) {
  std::vector<std::unique_ptr<Runner>> runners;
  for (std::size_t i = 0; i < request.contenders.size(); ++i) {
    const auto& [integrator, split, label] = request.contenders[i];
    const BuiltScene& scene = *scenes.for_integrator(integrator).built;
    RenderRequest render = render_request(request, scene, integrator, split);
    render.settings.seed = seed;
    render.reference = record.reference.rgb;
    runners.push_back(std::make_unique<Runner>(scene, render, record.reference, record.contenders[i]));
  }
  bool is_whole = true;
  while (is_whole) {
    Runner* next = nullptr;
    for (const auto& runner : runners)
      if (!runner->is_done && (next == nullptr || runner->rendering.cpu_seconds() < next->rendering.cpu_seconds()))
        next = runner.get();
    if (next == nullptr) break;
    is_whole = next->rendering.advance(executor) && !is_interrupted(request);
    next->is_done = next->has_enough(request);
  }
  for (std::size_t i = 0; i < runners.size(); ++i)
    if (runners[i]->rendering.progress().iterations > 0) {
      runners[i]->store(seed);
      RunRecord& run = record.contenders[i].runs.back();
      const BuiltScene& scene = *scenes.for_integrator(request.contenders[i].integrator).built;
      run.command = command_of(request, name, request.contenders[i], scene.scene().camera().resolution(), run,
                               runners[i]->expected_iterations);
    }
  return is_whole;
}

void write_logs(const ComparisonRequest& request, const SceneRecord& scene) {
  for (const ContenderRecord& contender : scene.contenders)
    for (const RunRecord& run : contender.runs) {
      std::string text = convergence_csv_header();
      for (const ConvergencePoint& point : run.points) text += '\n' + convergence_csv_row(point);
      text += '\n';
      write_whole(text, request.folder / (scene.name + "_" + file_name_of(contender.name) + "_seed" +
                                          std::to_string(run.seed) + ".csv"));
    }
}

/// The files of a scene bear its name.
void refuse_equal_names(const std::vector<std::string>& scenes) {
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (file_name_of(scenes[i]) == file_name_of(scenes[j]))
        throw InputError(scenes[j] + " and " + scenes[i] + " would write the same files, " + file_name_of(scenes[i]) +
                         "_*: rename one, or compare them one by one, each with a folder of its own in --out");
}

std::string limits_of(const ComparisonRequest& request) {
  std::string text;
  if (request.cpu_seconds) text = three_digits(*request.cpu_seconds) + " processor seconds";
  if (request.error) text += (text.empty() ? "" : " or ") + ("an error of " + percentage(*request.error));
  return text + " for every integrator and seed, " + std::to_string(request.seeds) +
         (request.seeds == 1 ? " seed" : " seeds");
}

}  // namespace

ComparisonRequest::Contender contender_of(const std::string& name) {
  const std::size_t slash = name.find('/');
  const char* const option = "--integrators";
  const IntegratorChoice integrator = integrator_of(name.substr(0, slash), option);
  if (slash == std::string::npos) return {integrator, SplitChoice::local, name_of(integrator)};
  if (integrator != IntegratorChoice::gmis) throw InputError(in_quotes(name) + ": only gmis splits");
  return {integrator, split_of(name.substr(slash + 1), option), name};
}

Comparison compare(const ComparisonRequest& request, ThreadedExecutor& executor) {
  Comparison comparison;
  comparison.limits = limits_of(request);
  comparison.settings = "paths of at most " + std::to_string(request.settings.max_depth) +
                        " segments, merging radius " +
                        (request.settings.radius ? text_of(*request.settings.radius) : "by default");
  comparison.machine = std::to_string(executor.thread_count()) + " threads on " +
                       std::to_string(std::max(1U, std::thread::hardware_concurrency())) + " processors";
  comparison.version = GMIS_VERSION;
  comparison.seeds = request.seeds;
  refuse_equal_names(request.scenes);
  for (const std::string& name : request.scenes) (void)find_scene(name);
  executor.stop_when(request.interrupted);
  for (const std::string& name : request.scenes) {
    LoadedScenes scenes(request, name);
    const BuiltScene& scene = *scenes.for_integrator(request.contenders.front().integrator).built;
    SceneRecord record;
    record.name = file_name_of(name);
    record.summary = scene.summary();
    std::optional<Reference> reference;
    if (!request.reference.empty()) {
      RenderRequest shown;
      shown.crop = scene.film_crop();
      reference = Reference{read_reference(request.reference, shown, scene.scene().camera().resolution()),
                            request.reference.filename().string(),
                            {}};
    } else if (request.reference_seconds > 0) {
      const auto& integrators = request.reference_integrators;
      const std::size_t index = integrators.size() > 1 ? comparison.scenes.size() : 0;
      const IntegratorChoice integrator = integrators.at(index);
      reference = make_reference(request, scenes.for_integrator(integrator), record.name, integrator, executor);
    } else {
      reference = Reference{{}, "none, errors are estimated from the spread between iterations", {}};
    }
    if (!reference) {
      comparison.is_whole = false;
      break;
    }
    record.reference = std::move(reference->image);
    record.reference_origin = reference->origin;
    record.reference_error = reference->error;
    for (const auto& contender : request.contenders) {
      record.contenders.emplace_back();
      record.contenders.back().name = contender.name;
      record.contenders.back().is_merging = merges(contender.integrator);
    }
    for (std::uint32_t seed = 0; seed < request.seeds && comparison.is_whole; ++seed) {
      request.say(record.name + ": seed " + std::to_string(seed + 1) + " of " + std::to_string(request.seeds));
      comparison.is_whole = run_seed(request, name, scenes, record, request.settings.seed + seed, executor);
    }
    write_logs(request, record);
    record.reference_file = kept(record.reference, record.name + "_reference", request.folder);
    for (ContenderRecord& contender : record.contenders) {
      if (!contender.image.rgb.empty() && contender.image.rgb.size() == record.reference.rgb.size())
        contender.picture_error = picture_error(contender.image, record.reference, exposure_of(record.reference));
      contender.file = kept(contender.image, record.name + "_" + file_name_of(contender.name), request.folder);
    }
    comparison.scenes.push_back(std::move(record));
    if (request.on_scene) request.on_scene(comparison);
    if (!comparison.is_whole) break;
  }
  executor.stop_when(nullptr);
  return comparison;
}

}  // namespace gmis::tools
