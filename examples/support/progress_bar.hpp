#pragma once

#include "support/render.hpp"

namespace gmis::tools {

/// A line on the terminal that shows how far a rendering is. Shows nothing when standard error is no terminal.
class ProgressBar {
 public:
  explicit ProgressBar(const RenderRequest& goal, bool is_wanted);
  ~ProgressBar() { finish(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  [[nodiscard]] bool is_shown() const { return is_shown_; }
  void show(const RunState& progress);
  /// Clears the line.
  void finish();

 private:
  [[nodiscard]] double fraction_done(const RunState& progress) const;

  std::optional<std::uint32_t> iterations_;
  std::optional<double> seconds_, relative_error_;
  bool is_shown_;
  bool has_drawn_ = false;
  double last_drawn_ = -1;
};

}  // namespace gmis::tools
