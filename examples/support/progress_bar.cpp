#include "support/progress_bar.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "support/plan_text.hpp"

namespace gmis::tools {

void Progress::end_iteration(const RunState& state, std::size_t pieces) {
  const double seconds =  // a run that was resumed has iterations from before
      (state.seconds - state_.seconds) / std::max(1U, state.iterations - state_.iterations);
  // The latest iterations say more than the first one, which has a pilot.
  constexpr double weight = 0.3;
  seconds_of_iteration_ =
      seconds_of_iteration_ ? *seconds_of_iteration_ + weight * (seconds - *seconds_of_iteration_) : seconds;
  pieces_of_iteration_ = std::max<std::size_t>(1, pieces - pieces_before_);
  pieces_before_ = pieces;
  const double known_error = state_.relative_error;
  state_ = state;
  if (!(state_.relative_error > 0)) state_.relative_error = known_error;
}

double Progress::part_of_iteration(std::size_t pieces) const {
  constexpr double most = 0.99;  // it may have more pieces than the one before
  return std::min(most, static_cast<double>(pieces - pieces_before_) / static_cast<double>(pieces_of_iteration_));
}

std::optional<double> Progress::iterations_for_error() const {
  if (!goal_.relative_error || !(state_.relative_error > 0)) return {};
  // The error falls with the square root of the work.
  const double ratio = state_.relative_error / *goal_.relative_error;
  return std::max<double>(state_.iterations * ratio * ratio, Budget::fewest_iterations_for_error);
}

double Progress::fraction_done(double seconds, std::size_t pieces) const {
  const double iterations = state_.iterations + part_of_iteration(pieces);
  double fraction = 0;
  if (goal_.iterations) fraction = std::max(fraction, iterations / *goal_.iterations);
  if (goal_.seconds) fraction = std::max(fraction, (state_.seconds + seconds) / *goal_.seconds);
  if (const auto needed = iterations_for_error()) fraction = std::max(fraction, iterations / *needed);
  return std::clamp(fraction, 0.0, 1.0);
}

std::optional<double> Progress::seconds_left(double seconds, std::size_t pieces) const {
  std::optional<double> least;
  const auto offer = [&](double left) { least = std::max(0.0, least ? std::min(*least, left) : left); };
  if (goal_.seconds) offer(*goal_.seconds - state_.seconds - seconds);
  std::optional<double> iteration = seconds_of_iteration_;
  const double part = part_of_iteration(pieces);
  constexpr double enough = 0.2;  // of the first iteration
  if (!iteration && part >= enough) iteration = seconds / part;
  if (!iteration) return least;
  const auto offer_iterations = [&](double count) { offer((count - state_.iterations - part) * *iteration); };
  if (goal_.iterations) offer_iterations(*goal_.iterations);
  if (const auto needed = iterations_for_error()) offer_iterations(*needed);
  return least;
}

std::string Progress::line(double seconds, std::size_t pieces) const {
  constexpr std::size_t width = 30;
  const double fraction = fraction_done(seconds, pieces);
  std::string bar(width, '.');
  std::fill_n(bar.begin(), static_cast<std::size_t>(fraction * width), '#');
  const std::optional<double> left = seconds_left(seconds, pieces);
  char numbers[96], error[16] = "–";
  if (state_.relative_error > 0) std::snprintf(error, sizeof error, "%.3f", state_.relative_error);
  std::snprintf(numbers, sizeof numbers, "] %3.0f %%  %u iterations  %.1f s  left ", 100 * fraction, state_.iterations,
                state_.seconds + seconds);
  return "[" + bar + numbers + (left ? duration_text(*left) : "–") + "  error " + error;
}

ProgressBar::ProgressBar(const Budget& goal, std::size_t pieces, bool is_wanted)
    : progress_(goal, pieces), is_shown_(is_wanted && isatty(STDERR_FILENO) == 1) {}

void ProgressBar::show(const RunState& state) {
  progress_.end_iteration(state, pieces_);
  iteration_start_ = Clock::now();
  draw();
}

void ProgressBar::show_piece(std::size_t pieces) {
  pieces_ = pieces;
  draw();
}

void ProgressBar::draw() {
  constexpr std::chrono::milliseconds between{100};
  const Clock::time_point now = Clock::now();
  if (!is_shown_ || (has_drawn_ && now - last_drawn_ < between)) return;
  has_drawn_ = true;
  last_drawn_ = now;
  const double seconds = std::chrono::duration<double>(now - iteration_start_).count();
  std::fprintf(stderr, "\r%s \x1b[K", progress_.line(seconds, pieces_).c_str());
  std::fflush(stderr);
}

void ProgressBar::finish() {
  if (!has_drawn_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  has_drawn_ = false;
}

}  // namespace gmis::tools
