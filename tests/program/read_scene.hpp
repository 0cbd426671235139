#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "support/diagnostics.hpp"
#include "support/scene_description.hpp"

namespace gmis_test {

/// A scene as it was read, with all that was said about it.
struct Read {
  gmis::tools::SceneDescription scene;
  gmis::tools::Diagnostics diagnostics;
  std::string error;  ///< of the first thing that ended it; else empty

  /// The number of notes, warnings and errors that hold this text.
  [[nodiscard]] std::ptrdiff_t count(const std::string& part) const {
    return std::count_if(diagnostics.all().begin(), diagnostics.all().end(), [&](const auto& diagnostic) {
      return diagnostic.to_string().find(part) != std::string::npos;
    });
  }
  [[nodiscard]] bool says(const std::string& part) const { return count(part) > 0; }
};

/// `read(diagnostics)` gives the scene, or throws `InputError`.
template <class Reader>
[[nodiscard]] Read reading(gmis::tools::Strictness strictness, Reader&& read) {
  Read result{{}, gmis::tools::Diagnostics(strictness), ""};
  try {
    result.scene = read(result.diagnostics);
  } catch (const gmis::tools::InputError& error) {
    result.error = error.what();
  }
  return result;
}

}  // namespace gmis_test
