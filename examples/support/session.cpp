#include "support/session.hpp"

#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <system_error>

#include "gmis/core/state_archive.hpp"
#include "support/choices.hpp"
#include "support/image/formats.hpp"

namespace gmis::tools {

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
  const double diagonal = 2 * scene.half_diagonal();
  if (options.radius && diagonal > 0 && !(*request.settings.radius < diagonal)) {
    std::ostringstream text;
    text << "--radius " << argument_of(*options.radius) << " is " << *request.settings.radius
         << " scene units, and the diagonal of the scene " << diagonal << ": choose less";
    throw InputError(text.str());
  }
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
  request.expected_iterations = options.expected_iterations.value_or(
      expected_iterations(request.budget, static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y),
                          ThreadedExecutor(options.threads).thread_count()));
  request.part = options.part;
  if (options.part) request.budget.iterations = options.part->length();
  return request;
}

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": there is no such file, or it is no regular file");
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || text.empty()) throw InputError(file.string() + ": this file cannot be read or is empty");
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

std::string digest_text(std::span<const std::byte> bytes) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(digest_of(bytes)));
  return text;
}

void identify_scene(RenderRequest& request, const LoadedScene& loaded) {
  request.scene_name = loaded.built->summary() + ", half diagonal " + std::to_string(loaded.built->half_diagonal());
  for (const std::filesystem::path& file : loaded.files)
    request.scene_properties.emplace_back("the content of " + file.filename().string(), digest_text(bytes_of(file)));
}

namespace {

/// The reference in the size that `read_reference` says.
Image fitting_reference(const std::filesystem::path& file, const RenderRequest& request, glm::ivec2 resolution) {
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

}  // namespace

Image read_reference(const std::filesystem::path& file, const RenderRequest& request, glm::ivec2 resolution) {
  Image reference = fitting_reference(file, request, resolution);
  for (const float value : reference.rgb)
    if (!(std::abs(value) <= 1e20F))
      throw InputError(file.string() + ": this reference has a value that is no number or above 1e20");
  return reference;
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
  // A closed terminal ends the run, too. What the caller ignores, as nohup or a shell's job in the
  // background does, stays ignored.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal, on_signal) == SIG_IGN) std::signal(signal, SIG_IGN);
  return interrupted;
}

}  // namespace gmis::tools
