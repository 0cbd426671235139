#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

#include "gmis/result/budget.hpp"

namespace gmis::tools {

/// How far a rendering is, and how long it will take: within an iteration by the share of its
/// pieces of work that are done; their number is taken from the iteration before.
class Progress {
 public:
  /// `pieces`: about how many pieces of work the first iteration has.
  Progress(const Budget& goal, std::size_t pieces) : goal_(goal), pieces_of_iteration_(pieces > 0 ? pieces : 1) {}

  /// An iteration has ended; `pieces` are done since the beginning.
  void end_iteration(const RunState& state, std::size_t pieces);

  /// The part of the run that is done, from 0 to 1, by the limit that is nearest. `seconds`: of
  /// wall time since the end of the latest iteration; `pieces`: done since the beginning.
  [[nodiscard]] double fraction_done(double seconds, std::size_t pieces) const;
  /// Wall time until the first limit is met; empty while it is not known.
  [[nodiscard]] std::optional<double> seconds_left(double seconds, std::size_t pieces) const;
  /// One line: a bar, iterations, time so far, time left, error; "–" for what is not known.
  [[nodiscard]] std::string line(double seconds, std::size_t pieces) const;

 private:
  /// The part of the iteration under way that is done, below 1.
  [[nodiscard]] double part_of_iteration(std::size_t pieces) const;
  /// Iterations that the goal of an error takes, as the present error has it.
  [[nodiscard]] std::optional<double> iterations_for_error() const;

  Budget goal_;
  RunState state_;
  std::size_t pieces_of_iteration_, pieces_before_ = 0;  ///< before: of whole iterations
  std::optional<double> seconds_of_iteration_;           ///< of the latest ones
};

/// A line on the terminal that shows how far a rendering is. Shows nothing when standard error is
/// no terminal.
class ProgressBar {
 public:
  /// `pieces`: as in `Progress`.
  ProgressBar(const Budget& goal, std::size_t pieces, bool is_wanted);
  ~ProgressBar() { finish(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  [[nodiscard]] bool is_shown() const { return is_shown_; }
  /// After an iteration.
  void show(const RunState& state);
  /// Within an iteration, when this number of pieces of work is done since the beginning.
  void show_piece(std::size_t pieces);
  /// Clears the line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw();

  Progress progress_;
  bool is_shown_;
  bool has_drawn_ = false;
  std::size_t pieces_ = 0;
  Clock::time_point iteration_start_ = Clock::now(), last_drawn_{};
};

}  // namespace gmis::tools
