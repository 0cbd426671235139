#pragma once

#include <cstdint>
#include <optional>

namespace gmis {

/// What can end a run.
enum class StopReason { iterations, time, error, interrupt, rejected };

[[nodiscard]] constexpr const char* name_of(StopReason reason) noexcept {
  constexpr const char* names[] = {"iterations", "time", "error", "interrupt", "rejected"};
  return names[static_cast<int>(reason)];
}

/// How far a progressive run is.
struct RunState {
  std::uint32_t iterations = 0;
  double seconds = 0.0;
  double relative_error = 0.0;  ///< estimated; 0 while it is not known
  bool is_calibrated = false;   ///< `ErrorEstimate::is_calibrated`: only then may the error end the run
};

/// What a run may cost, or how good it has to be: the first limit met ends it. A limit that is not set does not count.
struct Budget {
  /// An error estimated from fewer iterations is itself too uncertain to stop by.
  static constexpr std::uint32_t fewest_iterations_for_error = 8;

  std::optional<std::uint32_t> iterations;
  std::optional<double> seconds;
  std::optional<double> relative_error;

  /// Why to stop after the iterations done so far (at least one); nothing to go on. The time is met to the nearest
  /// whole iteration: one more is begun only if the mean length of those done lets half of it fit.
  [[nodiscard]] std::optional<StopReason> reason_to_stop(const RunState& state) const noexcept {
    if (iterations && state.iterations >= *iterations) return StopReason::iterations;
    if (relative_error && state.is_calibrated && state.iterations >= fewest_iterations_for_error &&
        state.relative_error <= *relative_error)
      return StopReason::error;
    const double half_iteration = state.seconds / state.iterations / 2.0;
    if (seconds && state.seconds + half_iteration >= *seconds) return StopReason::time;
    return {};
  }
};

}  // namespace gmis
