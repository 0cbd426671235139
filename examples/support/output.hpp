#pragma once

#include <filesystem>
#include <vector>

#include "support/image/formats.hpp"
#include "support/render.hpp"

/// \file
/// The files that a rendering leaves.

namespace gmis::tools {

/// The name of a file beside an output: its name with `suffix` before the ending.
[[nodiscard]] std::filesystem::path file_beside(const std::filesystem::path& output, const char* suffix);
/// Writes the image, and the halves beside it with `_a` and `_b` before the ending; layers go to
/// the image alone.
void write_output(const RenderResult& result, const std::filesystem::path& output, bool halves,
                  const ImageExtras& extras);
/// Where the images of path classes go: `NAME_classes` beside an output.
[[nodiscard]] std::filesystem::path class_folder(const std::filesystem::path& output);
/// All files that `write_classes` may write there.
[[nodiscard]] std::vector<std::filesystem::path> files_of_classes(const std::filesystem::path& folder);
/// Whether `write_techniques` may write a file of this name into its folder.
[[nodiscard]] bool may_be_of_technique(const std::filesystem::path& name);
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

}  // namespace gmis::tools
