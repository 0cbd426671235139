#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "gmis/result/batch_means.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/error_estimate.hpp"
#include "gmis/result/film.hpp"
#include "support/class_sums.hpp"
#include "support/render.hpp"
#include "support/technique_sums.hpp"

namespace gmis::tools {

/// A rendering that advances iteration by iteration, so that several can take turns. Wall
/// seconds are those spent in here, processor seconds those of them that went into the picture and not into its log.
class ProgressiveRender {
 public:
  using Spectrum = SceneSpectrum;

  /// Both must outlive this.
  ProgressiveRender(const BuiltScene& scene, const RenderRequest& request);

  /// One more iteration. False when the request's interruption cut it short: it is then left out.
  [[nodiscard]] bool advance(ThreadedExecutor& executor);
  /// Sees to it that the log ends with the latest iteration.
  void finish_log();
  /// Why to stop now; nothing to go on.
  [[nodiscard]] std::optional<StopReason> reason_to_stop() const;

  [[nodiscard]] const Progress& progress() const { return progress_; }
  [[nodiscard]] double cpu_seconds() const { return cpu_seconds_; }
  [[nodiscard]] const Film<Spectrum>& film() const { return film_; }
  /// What the latest iteration alone gives inside the crop.
  [[nodiscard]] std::span<const Spectrum> frame() const { return frame_; }
  [[nodiscard]] Image image() const;
  /// There when the request is for intervals or for an error, from the second iteration on.
  [[nodiscard]] std::optional<ErrorEstimate> error() const;
  /// What is known now, for a log.
  [[nodiscard]] ConvergencePoint point() const;
  [[nodiscard]] const ConvergenceLog& log() const { return log_; }
  [[nodiscard]] RenderResult result(StopReason reason) const;

 private:
  void take_frame();
  void look_at_error();
  void add_to_log();
  [[nodiscard]] bool is_replicated() const { return request_.settings.sampler == Sampler::sobol; }

  const RenderRequest& request_;
  glm::ivec2 resolution_;
  PixelBounds crop_;
  std::unique_ptr<SceneEngine> engine_;
  Film<Spectrum> film_;
  std::vector<Film<Spectrum>> halves_;
  std::optional<BatchMeans<Spectrum>> batches_;
  TechniqueSums techniques_;
  ClassSums classes_;
  std::span<const Spectrum> frame_;
  std::vector<Spectrum> part_;
  Progress progress_;
  std::optional<ErrorEstimate> latest_error_;  ///< after the iteration `looked_at_`
  std::uint32_t looked_at_ = 0, next_look_ = 2;
  ConvergenceLog log_;
  Counters counters_, light_work_;
  std::vector<RejectedPath> rejected_paths_;
  PhaseSeconds phases_;
  double film_seconds_ = 0;
  double cpu_seconds_ = 0;
};

}  // namespace gmis::tools
