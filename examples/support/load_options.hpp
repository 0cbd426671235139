#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace gmis::tools {

/// How a scene is read, beside what its file says.
struct LoadOptions {
  std::optional<std::uintmax_t> max_memory;  ///< in bytes, see `LoadBudget`
  std::optional<double> seconds;             ///< of animations; nothing: the scene as it stands
  std::string sky;  ///< studio, white, none or an image that replaces every sky; empty: as the scene has it
};

}  // namespace gmis::tools
