#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gmis/transport/plan/plan.hpp"
#include "support/render.hpp"
#include "support/statistics.hpp"

/// \file
/// The steps of gmis-render, one function each.

namespace gmis::tools {

/// A scene that is ready to be rendered, and how long that took.
struct LoadedScene {
  std::unique_ptr<BuiltScene> built;
  std::vector<Diagnostic> diagnostics;
  std::vector<std::filesystem::path> files;  ///< as in `SceneDescription`
  double read_seconds = 0;
  double build_seconds = 0;
};

/// `size` replaces that of the film.
[[nodiscard]] LoadedScene load_scene(const std::filesystem::path& file, std::optional<std::array<int, 2>> size,
                                     Strictness strictness = Strictness::strict,
                                     scene::LightSelection lights = scene::LightSelection::by_power,
                                     const LoadOptions& options = {});

/// Reads the scene and builds nothing: all that there is to say of it, errors included.
[[nodiscard]] Diagnostics check_scene_file(const std::filesystem::path& file, const LoadOptions& options = {});

/// The request that the options make for this scene. Throws `InputError` when the crop lies outside
/// the picture.
[[nodiscard]] RenderRequest request_of(const Options& options, const BuiltScene& scene);

/// One line per fact: what will be done, and why.
[[nodiscard]] std::string explain(const Options& options, const RenderRequest& request, const Plan& plan,
                                  const BuiltScene& scene, int threads);
/// The techniques that run with these counts, in one short line.
[[nodiscard]] std::string plan_of(const RenderRequest& request, const SampleCounts& counts);

/// Reads a reference and checks its size. One that is as large as the whole picture, or a whole
/// number of times as wide and high (it is then reduced to the means of blocks), is cut to the
/// crop.
[[nodiscard]] Image read_reference(const std::filesystem::path& file, const RenderRequest& request,
                                   glm::ivec2 resolution);

/// The name of a file beside an output: its name with `suffix` before the ending.
[[nodiscard]] std::filesystem::path file_beside(const std::filesystem::path& output, const char* suffix);
/// Writes the image, and the halves beside it with `_a` and `_b` before the ending; layers go to
/// the image alone.
void write_output(const RenderResult& result, const std::filesystem::path& output, bool halves,
                  const ImageExtras& extras);
/// Where the images of path classes go: `NAME_classes` beside an output.
[[nodiscard]] std::filesystem::path class_folder(const std::filesystem::path& output);
/// Writes `FOLDER/NAME.exr` (.pfm where that cannot be written) for every path class, and all of
/// them side by side: `sheet.png`. Images of other classes that an earlier run left there are
/// removed.
void write_classes(const RenderResult& result, const std::filesystem::path& folder);
/// The layers of the picture's file that --aov asks for: its variance, the path classes, NAME_sS_tT
/// for every technique, and light0, light1 … for the lights.
[[nodiscard]] std::vector<ImageLayer> layers_of(const RenderResult& result, const Options& options);
/// Writes `FOLDER/NAME_sS_tT.exr` (.pfm where that cannot be written) and the same with
/// `_unweighted` for every technique, and all of them side by side: `pyramid.png` and
/// `pyramid_unweighted.png`.
void write_techniques(const RenderResult& result, const std::filesystem::path& folder);

/// Set from now on by Ctrl-C, SIGTERM and SIGHUP; a second one ends the program at once.
[[nodiscard]] const std::atomic<bool>& interrupt_flag();

}  // namespace gmis::tools
