#include "support/load_scene.hpp"

#include <chrono>

#include "support/hidden_sky.hpp"
#include "support/read_scene.hpp"

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

}  // namespace gmis::tools
