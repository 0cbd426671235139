#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gmis/result/budget.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/counters.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/film.hpp"
#include "gmis/result/price.hpp"
#include "gmis/result/rejection_limit.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"
#include "support/image/image.hpp"
#include "support/options.hpp"
#include "support/scene_engine.hpp"

namespace gmis::tools {

/// How far a rendering is; seconds are wall time.
using Progress = RunState;

struct RenderRequest {
  IntegratorChoice integrator = IntegratorChoice::gmis;
  SplitChoice split = SplitChoice::local;
  RenderSettings settings;
  std::vector<SampleCounts> candidates;   ///< to choose the counts from; with fewer than two nothing is chosen
  std::uint32_t expected_iterations = 0;  ///< that the choice is made for
  std::optional<PixelBounds> crop;
  // Stops at the first one met; at least one iteration is done.
  Budget budget;                   ///< in wall time
  RejectionLimit rejection_limit;  ///< past it by more than chance the run stops
  const std::atomic<bool>* interrupted = nullptr;
  bool halves = false;
  bool techniques = false;
  bool class_images = false;         ///< with `settings.path_classes`
  bool intervals = false;            ///< keeps batches, for the error and its interval
  const Image* reference = nullptr;  ///< of the crop's size, for the log
  std::function<void(const Progress&)> on_iteration;
  std::function<void(const ConvergencePoint&)> on_log;  ///< at every point of the log
  /// While the run goes on, with the picture so far, whenever so many seconds have passed since it began or since the last
  /// time; with 0 after every iteration.
  std::function<void(const Image&)> on_picture;
  double seconds_between_pictures = 30;
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

struct PathClassResult {
  std::vector<ClassImage> classes;
  double unattributed_cost = 0;  ///< share of operations that nothing came of
};

struct RenderResult {
  Image image;
  Image half_a, half_b;  ///< means of the odd and of the even iterations, when asked for
  std::vector<TechniqueImage> techniques;
  PathClassResult classes;
  ImageEstimate estimate;
  std::optional<ErrorEstimate> error;  ///< when asked for, from the second iteration on
  std::optional<PriceTable> prices;    ///< of the usual errors, then of half the last one, when the log knows enough
  Counters counters;
  std::vector<RejectedPath> rejected_paths;  ///< the first of them
  SampleCounts counts;                       ///< that the last iteration was made with
  std::optional<Choice> choice;              ///< how they were chosen
  double radius = 0;                         ///< of merging in the first iteration, in scene units; 0: nothing merges
  PhaseSeconds phases;
  double wall_seconds = 0;
  double cpu_seconds = 0;
  std::uint32_t iterations = 0;
  std::string stopped_by;
  std::size_t photon_bytes = 0;
};

/// Renders on the threads of `executor`, until the budget is met.
[[nodiscard]] RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor);

/// The engine that is asked for, ready for its first iteration.
[[nodiscard]] std::unique_ptr<SceneEngine> start(const BuiltScene& scene, const RenderRequest& request);

}  // namespace gmis::tools
