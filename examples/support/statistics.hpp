#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "gmis/result/image_error.hpp"
#include "gmis/transport/plan/plan.hpp"
#include "support/render.hpp"

namespace gmis::tools {

/// The facts in the statistics file that the result itself does not have.
struct RunFacts {
  const Options* options = nullptr;
  std::string plan;   ///< in words
  Plan scene_plan{};  ///< what the scene calls for
  int threads = 1;
  double read_seconds = 0;   ///< parsing the scene's files
  double build_seconds = 0;  ///< the tree over its surfaces
  std::optional<ImageError> error;
  double ratio_of_means = 1;  ///< with an error: of the picture over the reference
};

/// The text of the file: JSON with the keys that docs/gmis-render.md lists.
[[nodiscard]] std::string statistics_json(const RenderResult& result, const RunFacts& facts);

/// The most memory this process ever held, in bytes.
[[nodiscard]] std::size_t peak_memory_bytes();

}  // namespace gmis::tools
