#pragma once

#include <cstdint>
#include <optional>

namespace gmis {

/// The reason why a run ended; `joined` for runs that were put together after their ends
/// (render/join_runs.hpp).
enum class StopReason { iterations, time, error, interrupt, rejected, joined };

/// The name of a reason in statistics files.
[[nodiscard]] constexpr const char* name_of(StopReason reason) noexcept {
  constexpr const char* names[] = {"iterations", "time", "error", "interrupt", "rejected", "joined"};
  return names[static_cast<int>(reason)];
}

/// Progress of a run.
struct RunState {
  std::uint32_t iterations = 0;  ///< done so far
  double seconds = 0.0;          ///< wall time so far
  double relative_error = 0.0;   ///< √relMSE by the latest estimate; 0 before the first
  /// The error may end the run: `ErrorEstimate::is_calibrated`, or `Budget::most_iterations_alike`
  /// is reached.
  bool is_calibrated = false;

  /// The state for a later run (`core/state_archive.hpp`): member by member, for bytes between them
  /// have no value.
  template <class Archive>
  void exchange_state(Archive& archive) {
    archive(iterations, seconds, relative_error, is_calibrated);
  }
};

/// Limits on iterations, time and error of a run. The first limit that is reached ends the run. An
/// unset limit has no effect.
struct Budget {
  /// Minimum number of iterations before an error estimate may end a run; estimates from fewer
  /// iterations are too uncertain.
  static constexpr std::uint32_t fewest_iterations_for_error = 8;
  /// From this number of iterations on, a limit on the error ends a run whose iterations are all
  /// alike: there is no noise, or nothing will be found (`ErrorDoubt::nothing_found`).
  static constexpr std::uint32_t most_iterations_alike = 256;

  std::optional<std::uint32_t> iterations{};  ///< stop after this number of iterations
  std::optional<double> seconds{};            ///< stop after this wall time
  std::optional<double> relative_error{};     ///< stop at this error, once it is calibrated

  /// The reason to stop after the iterations so far (at least one), or nothing to go on. The run
  /// ends at the whole iteration nearest to the time limit: one more iteration begins only when
  /// half of a mean iteration still fits.
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
