#include "support/progress_bar.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace gmis::tools {

ProgressBar::ProgressBar(const RenderRequest& goal, bool is_wanted)
    : iterations_(goal.budget.iterations),
      seconds_(goal.budget.seconds),
      relative_error_(goal.budget.relative_error),
      is_shown_(is_wanted && isatty(STDERR_FILENO) == 1) {}

double ProgressBar::fraction_done(const RunState& progress) const {
  double fraction = 0;
  if (iterations_) fraction = std::max(fraction, static_cast<double>(progress.iterations) / *iterations_);
  if (seconds_) fraction = std::max(fraction, progress.seconds / *seconds_);
  if (relative_error_ && progress.relative_error > 0) {
    // The error falls with the square root of the work.
    const double ratio = *relative_error_ / progress.relative_error;
    fraction = std::max(fraction, ratio * ratio);
  }
  return std::clamp(fraction, 0.0, 1.0);
}

void ProgressBar::show(const RunState& progress) {
  constexpr double seconds_between = 0.1;
  if (!is_shown_ || (has_drawn_ && progress.seconds - last_drawn_ < seconds_between)) return;
  has_drawn_ = true;
  last_drawn_ = progress.seconds;
  constexpr std::size_t width = 30;
  const double fraction = fraction_done(progress);
  std::string bar(width, '.');
  std::fill_n(bar.begin(), static_cast<std::size_t>(fraction * width), '#');
  std::fprintf(stderr, "\r[%s] %3.0f %%  %u iterations  %.1f s  ", bar.c_str(), 100 * fraction, progress.iterations,
               progress.seconds);
  if (progress.relative_error > 0)
    std::fprintf(stderr, "error %.3f ", progress.relative_error);
  else
    std::fputs("error -     ", stderr);  // not known yet
  std::fflush(stderr);
}

void ProgressBar::finish() {
  if (!has_drawn_) return;
  std::fprintf(stderr, "\r%78s\r", "");
  std::fflush(stderr);
  has_drawn_ = false;
}

}  // namespace gmis::tools
