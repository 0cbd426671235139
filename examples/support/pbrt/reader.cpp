#include "support/pbrt/reader.hpp"

#include "support/pbrt/parser.hpp"

namespace gmis::tools {

SceneDescription read_pbrt_scene(const std::filesystem::path& file, Diagnostics& diagnostics,
                                 const LoadOptions& options) {
  SceneDescription scene;
  LoadBudget budget(options.max_memory.value_or(LoadBudget::default_limit()));
  pbrt::Parser parser(file.parent_path(), scene, diagnostics, budget);
  parser.parse_file(file);
  parser.finish(file.string());
  return scene;
}

SceneDescription read_pbrt_text(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                                Diagnostics& diagnostics, const LoadOptions& options) {
  SceneDescription scene;
  LoadBudget budget(options.max_memory.value_or(LoadBudget::default_limit()));
  pbrt::Parser parser(folder, scene, diagnostics, budget);
  parser.parse_text(text, name);
  parser.finish(name);
  return scene;
}

}  // namespace gmis::tools
