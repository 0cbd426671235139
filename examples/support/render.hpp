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
#include "gmis/transport/candidate.hpp"
#include "gmis/transport/contribution.hpp"
#include "gmis/transport/engine.hpp"
#include "gmis/transport/settings.hpp"
#include "support/build_scene.hpp"
#include "support/executor.hpp"
#include "support/frame_source.hpp"
#include "support/image/image.hpp"
#include "support/options.hpp"

namespace gmis::tools {

/// How far a rendering is; seconds are wall time.
using Progress = RunState;

struct RenderRequest {
  IntegratorChoice integrator = IntegratorChoice::gmis;
  SplitChoice split = SplitChoice::budgeted;
  RenderSettings settings;
  bool fixes_light_paths = false;  ///< their number was asked for, so that `auto` does not choose it
  std::optional<PixelBounds> crop;
  // Stops at the first one met; at least one iteration is done.
  Budget budget;                   ///< in wall time
  RejectionLimit rejection_limit;  ///< past it by more than chance the run stops
  const std::atomic<bool>* interrupted = nullptr;
  bool halves = false;
  bool techniques = false;
  bool class_images = false;  ///< with `classifies`
  /// Contributions carry the class of their path, and only those of `settings.path_classes` are made.
  bool classifies = false;
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

/// What a pilot found out about the candidates, and which of them was chosen.
struct MeasuredChoice {
  std::vector<Forecast> forecasts;
  std::size_t chosen = 0;        ///< its place among them
  double least_by_region = 1.0;  ///< variance × cost, over the chosen one's, if each region of the picture could choose
  std::uint32_t expected_iterations = 0;  ///< that the choice is best for
  std::uint32_t pilot_iterations = 0;     ///< part of the picture like all others
  double pilot_cost = 0;                  ///< counted operations, as `Forecast::cost`
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
  Tuning tuning;                             ///< the counts that the last iteration was made with
  std::vector<Trial> trials;                 ///< how they were measured
  std::optional<MeasuredChoice> choice;      ///< of the techniques and their counts, with auto
  PhaseSeconds phases;
  double wall_seconds = 0;
  double cpu_seconds = 0;
  std::uint32_t iterations = 0;
  std::string stopped_by;
  std::size_t photon_bytes = 0;
};

/// Renders on the threads of `executor`, until the budget is met.
[[nodiscard]] RenderResult render(const BuiltScene& scene, const RenderRequest& request, ThreadedExecutor& executor);

/// The integrator that is asked for, ready for its first iteration.
[[nodiscard]] std::unique_ptr<FrameSource> start(const BuiltScene& scene, const RenderRequest& request);

/// Measures with a pilot that has the techniques of vcm or of bpt, then goes on with the best of the candidates.
[[nodiscard]] std::unique_ptr<FrameSource> start_measured_vcm(const BuiltScene&, const RenderRequest&,
                                                              std::vector<Candidate>);
[[nodiscard]] std::unique_ptr<FrameSource> start_measured_bpt(const BuiltScene&, const RenderRequest&,
                                                              std::vector<Candidate>);

// One per integrator, each in a file of its own: the engine is compiled anew for each.
[[nodiscard]] std::unique_ptr<FrameSource> start_classified_pt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_classified_pt_lt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_classified_pt_lt_pm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_classified_bpt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_classified_vcm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_pt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_pt_lt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_pt_lt_pm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_lt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_ppm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_bpm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_bpt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_vcm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_split_pt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_split_pt_lt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_split_pt_lt_pm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_split_bpt(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_split_vcm(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_gmis_paper(const BuiltScene&, const RenderRequest&);
[[nodiscard]] std::unique_ptr<FrameSource> start_gmis_budgeted(const BuiltScene&, const RenderRequest&);

}  // namespace gmis::tools
