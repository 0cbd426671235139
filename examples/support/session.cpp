#include "support/session.hpp"

#include <chrono>
#include <csignal>
#include <cstdint>
#include <limits>
#include <sstream>

#include "support/choices.hpp"
#include "support/hidden_sky.hpp"
#include "support/image/formats.hpp"
#include "support/plan_text.hpp"
#include "support/read_scene.hpp"
#include "support/technique_sheet.hpp"

namespace gmis::tools {

Diagnostics check_scene_file(const std::filesystem::path& file, const LoadOptions& options) {
  Diagnostics diagnostics(Strictness::check);
  const SourcePosition start{std::make_shared<const std::string>(file.string()), 0};
  try {
    const SceneDescription description = read_scene(file, diagnostics, options);
    if (diagnostics.error_count() == 0) (void)build_scene(description, diagnostics);
  } catch (const InputError& error) {
    diagnostics.error(error.where().value_or(start), error.message());
  }
  return diagnostics;
}

LoadedScene load_scene(const std::filesystem::path& file, std::optional<std::array<int, 2>> size, Strictness strictness,
                       scene::LightSelection lights, const LoadOptions& options) {
  using Clock = std::chrono::steady_clock;
  LoadedScene loaded;
  const auto start = Clock::now();
  Diagnostics diagnostics(strictness);
  SceneDescription description = read_scene(file, diagnostics, options);
  const auto read = Clock::now();
  if (size) {
    description.film.width = (*size)[0];
    description.film.height = (*size)[1];
  }
  loaded.built = build_scene(description, diagnostics, lights);
  if (description.camera_outside && sky_is_hidden(*loaded.built)) {
    description.camera = *description.camera_outside;
    diagnostics.warning(description.camera.where,
                        "surfaces enclose the camera, and no light is inside: all of the scene is seen from before and "
                        "above");
    loaded.built.reset();
    loaded.built = build_scene(description, diagnostics, lights);
  }
  loaded.files = std::move(description.files);
  loaded.diagnostics = diagnostics.all();
  loaded.read_seconds = std::chrono::duration<double>(read - start).count();
  loaded.build_seconds = std::chrono::duration<double>(Clock::now() - read).count();
  return loaded;
}

RenderRequest request_of(const Options& options, const BuiltScene& scene) {
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  constexpr std::uint32_t most_trees = std::numeric_limits<std::uint32_t>::max();
  const double light_paths = options.light_paths.value_or(1.0);
  if (light_paths * resolution.x * resolution.y > most_trees)
    throw InputError("--light-paths asks for more than " + std::to_string(most_trees) +
                     " light trees in a picture of " + std::to_string(resolution.x) + "x" +
                     std::to_string(resolution.y) + ": choose fewer");
  RenderRequest request;
  request.integrator = options.integrator;
  request.split = options.split;
  request.settings.seed = options.seed;
  request.settings.max_depth = options.max_depth;
  if (options.radius)
    request.settings.radius =
        options.radius->value * (options.radius->is_in_scene_units ? 1.0 : median_pixel_width(scene.scene()));
  request.settings.alpha = options.alpha;
  request.settings.sampler = options.sampler;
  request.settings.emission = options.emission;
  request.budget.iterations = options.iterations;
  request.budget.seconds = options.seconds;
  request.budget.relative_error = options.relative_error;
  request.rejection_limit = {options.max_rejected};
  request.halves = options.halves;
  request.techniques = !options.techniques_folder.empty() || options.technique_layers;
  request.class_pictures = options.class_images;
  request.light_pictures = options.light_layers;
  request.settings.path_classes = options.path_classes;
  if (options.class_images && !options.path_classes) request.settings.path_classes = PathClassSet::all();
  if (!options.crop) request.crop = scene.film_crop();
  if (options.crop) {
    const auto& [x0, y0, x1, y1] = *options.crop;
    if (x1 > resolution.x || y1 > resolution.y)
      throw InputError("--crop ends outside the picture, which is " + std::to_string(resolution.x) + "x" +
                       std::to_string(resolution.y));
    request.crop = PixelBounds{{x0, y0}, {x1, y1}};
  }
  set_counts(request, options, scene);
  const glm::ivec2 size =
      request.crop ? glm::max(request.crop->upper - request.crop->lower, glm::ivec2(0)) : resolution;
  request.expected_iterations =
      expected_iterations(request.budget, static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y),
                          ThreadedExecutor(options.threads).thread_count());
  request.part = options.part;
  if (options.part) request.budget.iterations = options.part->length();
  return request;
}

std::string plan_of(const RenderRequest& request, const SampleCounts& counts) {
  std::string plan;
  for (const Technique technique : all_techniques) {
    if (!counts.has(technique)) continue;
    if (!plan.empty()) plan += ", ";
    plan += words_of(technique);
    if (technique != Technique::connect) continue;
    plan += counts.connects_paired_tree ? " (paired" : " (" + std::to_string(counts.connections);
    plan += " a vertex)";
  }
  if (!counts.extends_camera && counts.has(Technique::merge)) plan += " at the first non-specular vertex";
  if (counts.has(Technique::merge) && counts.local_merges) plan += " (photons that come from narrow lobes)";
  if (request.integrator == IntegratorChoice::gmis && request.split != SplitChoice::local) {
    plan += "; subpaths split: " + std::string(name_of(request.split));
    if (request.sampler) plan += " by " + std::string(gmis::name_of(request.sampler->scheme));
  }
  return plan.empty() ? "nothing" : plan;
}

std::string explain(const Options& options, const RenderRequest& request, const Plan& plan, const BuiltScene& scene,
                    int threads) {
  std::ostringstream text;
  const glm::ivec2 resolution = scene.scene().camera().resolution();
  text << "scene       " << scene.summary() << "\n";
  text << "picture     " << resolution.x << "x" << resolution.y;
  if (request.crop)
    text << ", of it " << request.crop->lower.x << "," << request.crop->lower.y << " to " << request.crop->upper.x
         << "," << request.crop->upper.y;
  text << "\nintegrator  " << name_of(request.integrator);
  const SampleCounts& counts = request.settings.counts;
  if (options.lights == scene::LightSelection::by_receiver)
    text << "\nlights      of next events by power, distance and orientation as the receiver sees them";
  if (options.emission == Emission::learned && options.integrator != IntegratorChoice::automatic)
    text << "\nemission    of light subpaths learned: where their light is needed";
  text << "\ntechniques  " << plan_of(request, counts) << "\n" << explain_plan(request, plan);
  if (request.candidates.size() > 1)
    text << "choice      a pilot chooses among " << request.candidates.size()
         << " sets of counts, each with these techniques or fewer\n";
  const bool is_merging = counts.has(Technique::merge);
  if (counts.traces_light()) text << "light       " << counts.light_paths << " trees a pixel\n";
  if (request.integrator == IntegratorChoice::lt)
    text << "lacks       what is seen in mirrors and through glass, except the lights themselves\n";
  if (is_merging)
    text << "radius      "
         << counts.radius_factor * (request.settings.radius ? *request.settings.radius : default_radius(scene.scene()))
         << " = " << text_of(options.radius.value_or(RadiusChoice{counts.radius_factor * 0.4})) << ", times i^"
         << (request.settings.alpha - 1) / 2 << "\n";
  if (request.split == SplitChoice::paper && request.integrator == IntegratorChoice::gmis)
    text << "bias        this split policy drops what waits at the end of its budget: the picture is too dark\n";
  text << "threads     " << threads << "\nstops       ";
  const char* separator = "";
  const auto stop = [&](const auto& value, const char* unit) {
    text << separator << "after " << value << unit;
    separator = " or ";
  };
  if (request.budget.iterations) stop(*request.budget.iterations, " iterations");
  if (request.budget.seconds) stop(*request.budget.seconds, " seconds");
  if (request.budget.relative_error) text << separator << "at a relative error of " << *request.budget.relative_error;
  text << "\n";
  return text.str();
}

Image read_reference(const std::filesystem::path& file, const RenderRequest& request, glm::ivec2 resolution) {
  Image reference = read_image(file);
  const PixelBounds part = request.crop.value_or(PixelBounds{{0, 0}, resolution});
  const glm::ivec2 size = part.upper - part.lower;
  if (reference.width == resolution.x && reference.height == resolution.y)
    return cropped(reference, part.lower.x, part.lower.y, part.upper.x, part.upper.y);
  const int factor = reference.width / resolution.x;
  if (factor > 1 && reference.width == factor * resolution.x && reference.height == factor * resolution.y)
    return cropped(reduced(reference, factor), part.lower.x, part.lower.y, part.upper.x, part.upper.y);
  if (reference.width != size.x || reference.height != size.y)
    throw InputError(file.string() + ": this reference is " + std::to_string(reference.width) + "x" +
                     std::to_string(reference.height) + ", the picture " + std::to_string(size.x) + "x" +
                     std::to_string(size.y) + ": see --size");
  return reference;
}

std::filesystem::path file_beside(const std::filesystem::path& output, const char* suffix) {
  auto file = output;
  return file.replace_filename(output.stem().string() + suffix + output.extension().string());
}

void write_output(const RenderResult& result, const std::filesystem::path& output, bool halves,
                  const ImageExtras& extras) {
  write_image(result.image, output, extras);
  if (!halves) return;
  ImageExtras of_halves = extras;
  of_halves.layers.clear();
  write_image(result.half_a, file_beside(output, "_a"), of_halves);
  write_image(result.half_b, file_beside(output, "_b"), of_halves);
}

std::filesystem::path class_folder(const std::filesystem::path& output) {
  return output.parent_path() / (output.stem().string() + "_classes");
}

void write_classes(const RenderResult& result, const std::filesystem::path& folder) {
  const auto file_of = [&](PathClass path_class) {
    return folder / (std::string(gmis::name_of(path_class)) + (has_exr() ? ".exr" : ".pfm"));
  };
  // What an earlier run left there would be taken for a part of this picture.
  std::error_code ignored;
  PathClassSet::all().for_each([&](PathClass path_class) { std::filesystem::remove(file_of(path_class), ignored); });
  for (const ClassImage& one : result.classes.classes) write_image(one.image, file_of(one.path_class));
  write_image(class_sheet(result.classes.classes), folder / (std::string("sheet") + (has_png() ? ".png" : ".pfm")));
}

namespace {

std::string file_name_of(const TechniqueId& id) {
  return std::string(name_of(id.technique)) + "_s" + std::to_string(id.s) + "_t" + std::to_string(id.t);
}

}  // namespace

std::vector<ImageLayer> layers_of(const RenderResult& result, const Options& options) {
  std::vector<ImageLayer> layers;
  if (options.layers && !result.variance.rgb.empty()) layers.push_back({"variance", "RGB", result.variance});
  if (options.layers)
    for (const ClassImage& one : result.classes.classes)
      layers.push_back({std::string(gmis::name_of(one.path_class)), "RGB", one.image});
  if (options.technique_layers)
    for (const TechniqueImage& one : result.techniques) layers.push_back({file_name_of(one.id), "RGB", one.weighted});
  for (const LightImage& one : result.by_light) layers.push_back({name_of_light(one.group), "RGB", one.image});
  return layers;
}

void write_techniques(const RenderResult& result, const std::filesystem::path& folder) {
  const std::string ending = has_exr() ? ".exr" : ".pfm";
  for (const TechniqueImage& technique : result.techniques) {
    const std::string name = file_name_of(technique.id);
    write_image(technique.weighted, folder / (name + ending));
    write_image(technique.unweighted, folder / (name + "_unweighted" + ending));
  }
  const std::string sheet_ending = has_png() ? ".png" : ".pfm";
  write_image(technique_sheet(result.techniques, true), folder / ("pyramid" + sheet_ending));
  write_image(technique_sheet(result.techniques, false), folder / ("pyramid_unweighted" + sheet_ending));
}

namespace {

std::atomic<bool> interrupted{false};

extern "C" void on_signal(int signal) {
  interrupted.store(true);
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& interrupt_flag() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  // A terminal that is closed ends the run, unless nohup said that it must not.
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  return interrupted;
}

}  // namespace gmis::tools
