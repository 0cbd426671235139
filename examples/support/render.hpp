#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gmis/render/render_request.hpp"
#include "gmis/render/render_result.hpp"
#include "gmis/transport/splitting/gmis_sampler.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"
#include "support/image/image.hpp"
#include "support/options.hpp"
#include "support/scene_engine.hpp"

namespace gmis::tools {

/// A request, and the names on the command line that it comes from.
struct RenderRequest : gmis::RenderRequest {
  IntegratorChoice integrator = IntegratorChoice::gmis;
  SplitChoice split = SplitChoice::local;
  std::optional<GmisSampler> sampler;  ///< light trees split by it; empty: they do not split
  /// Checkpoints: none for a new run, one to go on from, several of runs to be joined without
  /// rendering.
  std::vector<std::vector<std::byte>> resume;
  std::vector<std::filesystem::path> resume_files;  ///< where they are from
};

/// The part of the image that one technique makes.
struct TechniqueImage {
  TechniqueId id;
  Image weighted;    ///< as it adds to the image
  Image unweighted;  ///< as if it were the only technique
};

/// The part of the image that the paths of one class make.
struct ClassImage {
  PathClass path_class = PathClass::unclassified;
  Image image;
  std::uint64_t contributions = 0;
  double cost = 0;  ///< share of all counted operations, as `costs_of_classes` attributes them
};

/// The part of the image whose light comes from one light.
struct LightImage {
  std::uint16_t group = 0;  ///< `BvhScene::light_group`
  Image image;
};
[[nodiscard]] inline std::string name_of_light(std::uint16_t group) {
  return "light" + std::to_string(group);
}

struct PathClassResult {
  std::vector<ClassImage> classes;
  double unattributed_cost = 0;  ///< share of operations that led to no contribution
};

/// `gmis::RenderResult` with images that can be written to files.
struct RenderResult : RenderSummary {
  Image image;
  Image variance;        ///< of the image's values; without pixels where it is not known
  Image half_a, half_b;  ///< means of the odd and of the even iterations, when asked for
  std::vector<TechniqueImage> techniques;
  PathClassResult classes;
  std::vector<LightImage> by_light;
};

[[nodiscard]] inline Image image_of(const Picture& picture) {
  Image image(picture.size.x, picture.size.y);
  image.rgb = picture.values;
  return image;
}

/// Renders on the threads of `executor`, until the budget is met, or joins runs.
[[nodiscard]] RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor);

/// The engine that is asked for, ready for its first iteration.
[[nodiscard]] std::unique_ptr<SceneEngine> start(const BuiltScene& scene, const RenderRequest& request);

}  // namespace gmis::tools
