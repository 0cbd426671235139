#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gmis/transport/plan/plan.hpp"
#include "support/load_scene.hpp"
#include "support/render.hpp"
#include "support/statistics.hpp"

/// \file
/// The steps of gmis-render, one function each.

namespace gmis::tools {

/// The request that the options make for this scene. Throws `InputError` when the crop lies outside
/// the picture, --light-paths asks for too many light trees or --radius is as large as the scene.
[[nodiscard]] RenderRequest request_of(const Options& options, const BuiltScene& scene);

/// Reads a reference, which has the size of the crop, of the whole picture, or of an integer
/// multiple of the whole picture. The last is reduced to the means of blocks; both of the latter
/// are cut to the crop. Throws `InputError` for any other size, and for a value that is no number.
[[nodiscard]] Image read_reference(const std::filesystem::path& file, const RenderRequest& request,
                                   glm::ivec2 resolution);

/// The bytes of a regular file. Throws `InputError` when there are none.
[[nodiscard]] std::vector<std::byte> bytes_of(const std::filesystem::path& file);

/// `digest_of` these bytes, in 16 hexadecimal digits.
[[nodiscard]] std::string digest_text(std::span<const std::byte> bytes);

/// Names the scene of the request: what it describes, and a digest of each of its files.
void identify_scene(RenderRequest& request, const LoadedScene& loaded);

/// Set from now on by Ctrl-C, SIGTERM and SIGHUP, but for those that the caller ignores; a second
/// one ends the program at once.
[[nodiscard]] const std::atomic<bool>& interrupt_flag();

}  // namespace gmis::tools
