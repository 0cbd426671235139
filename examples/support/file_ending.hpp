#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace gmis::tools {

/// The ending of a file's name in lower case, with its dot; empty where there is none.
[[nodiscard]] inline std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace gmis::tools
