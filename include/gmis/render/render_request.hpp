#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gmis/render/picture.hpp"
#include "gmis/render/ranks.hpp"
#include "gmis/result/budget.hpp"
#include "gmis/result/convergence_log.hpp"
#include "gmis/result/rejection_limit.hpp"
#include "gmis/result/time_to_error.hpp"
#include "gmis/transport/state/pixel_bounds.hpp"
#include "gmis/transport/state/settings.hpp"

namespace gmis {

/// A part of a run that is rendered by itself; iterations are numbered from 1.
struct RunPart {
  std::uint32_t first = 1;  ///< its first iteration
  std::uint32_t last = 1;   ///< its last iteration, which belongs to it
  std::uint32_t of = 1;     ///< iterations of the whole run
  /// Number of iterations in it.
  [[nodiscard]] constexpr std::uint32_t length() const noexcept { return last - first + 1; }
};

/// Settings and limits of a whole rendering, and which results it keeps. `automatic_request` fills
/// in the counts and the candidates by the scene.
struct RenderRequest {
  RenderSettings settings;  ///< techniques and counts, seed, depth, radius
  /// The counts that a pilot chooses from. One: these counts, without a pilot; none:
  /// `settings.counts`. With two or more, `settings.counts` must have every technique that any of
  /// them has.
  std::vector<SampleCounts> candidates;
  std::uint32_t expected_iterations = 0;  ///< length of the run that the pilot chooses for
  std::optional<PixelBounds> crop;        ///< the part to render, clipped to the frame; unset: the whole frame

  Budget budget;                   ///< its first limit that is met ends the run, after at least 1 iteration
  RejectionLimit rejection_limit;  ///< a run that surely exceeds it ends
  const std::atomic<bool>* interrupt = nullptr;  ///< set to true from anywhere, it ends the run

  /// Processes that share the iterations; by default this one alone. All of them have the same
  /// request but for limits, callbacks and reference, of which those of rank 0 count.
  RanksRef ranks;

  /// Renders this part of a run alone, in place of `budget`'s number of iterations, and keeps each
  /// of its frames in checkpoints. `join_runs` puts the parts of a run together to the bits of a
  /// run that was never divided. Unset: the whole run.
  std::optional<RunPart> part;

  /// Identifies the scene in checkpoints, for example by a digest of its files.
  std::string scene_name;
  /// More that identifies it, each with a name for messages: digests of files that it refers to,
  /// how it was built.
  std::vector<std::pair<std::string, std::string>> scene_properties;

  // Kept on request, because each costs memory and time.
  bool intervals = false;       ///< batches of iterations, for the error and its interval; implied by an error budget
  bool halves = false;          ///< the means of the odd and of the even iterations
  bool techniques = false;      ///< a picture of each technique
  bool class_pictures = false;  ///< a picture of each of `settings.path_classes`
  bool light_pictures = false;  ///< a picture of each group of lights, in a `SceneWithLightGroups`
  /// True when one of the three kinds of pictures is asked for that are made of single
  /// contributions.
  [[nodiscard]] constexpr bool keeps_contributions() const noexcept {
    return techniques || class_pictures || light_pictures;
  }

  /// The true picture, laid out like `Picture::values` of the crop, for the errors in the log. It
  /// must outlive the run.
  std::span<const float> reference;

  // Called between iterations by the thread that renders.
  /// After each iteration; with several ranks after each round.
  std::function<void(const RunState&)> on_iteration;
  /// Once, with the prices that the pilot's choice expects: after two iterations with the chosen
  /// counts.
  std::function<void(const PriceTable&)> on_forecast;
  std::function<void(const ConvergencePoint&)> on_log;  ///< at every point of the convergence log
  std::function<void(const Picture&)> on_picture;       ///< with the picture so far, now and then; not with the last
  /// With the state of the run (`Render::checkpoint`): after the first iteration, now and then, and
  /// after the last one.
  std::function<void(std::span<const std::byte>)> on_checkpoint;
  double seconds_between_pictures = 30.0;  ///< and between checkpoints; 0: at every call of `on_iteration`
};

}  // namespace gmis
