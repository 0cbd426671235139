#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "gmis/transport/replay/replay.hpp"
#include "support/render.hpp"

/// \file
/// Paths that were rejected, and paths replayed, as text.

namespace gmis::tools {

/// ITERATION:NUMBER and ITERATION:light:NUMBER, as --replay takes it.
[[nodiscard]] std::string text_of(const PathName& path);
[[nodiscard]] const char* text_of(RejectionCause cause);
/// "next_event s1 t3", with its class where that is known.
[[nodiscard]] std::string text_of(const TechniqueId& technique);

/// A line per path: its name, where it is, how many of its contributions were left out and why.
[[nodiscard]] std::string rejected_text(std::span<const RejectedPath> paths, glm::ivec2 resolution);

/// The path that the choice names. Throws `InputError` when there is none such in this picture.
[[nodiscard]] PathName path_of(const PathChoice& choice, const RenderRequest& request, glm::ivec2 resolution);

/// One path of the run that `request` describes, traced again alone. Throws `InputError` for a
/// light tree that does not exist.
[[nodiscard]] ReplayedPath<SceneSpectrum> replay(const BuiltScene& scene, const RenderRequest& request,
                                                 ThreadedExecutor& executor, const PathName& path);

/// Everything about the path, a fact per line; floating-point numbers with all their digits.
[[nodiscard]] std::string replay_text(const ReplayedPath<SceneSpectrum>& path, const RenderRequest& request,
                                      glm::ivec2 resolution);

}  // namespace gmis::tools
