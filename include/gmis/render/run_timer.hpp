#pragma once

#include <chrono>
#include <ctime>

namespace gmis {

namespace detail {

/// Adds the wall time and the processor time of its lifetime to two sums.
class RunTimer {
 public:
  RunTimer(double& wall, double& cpu) : wall_(wall), cpu_(cpu) {}
  ~RunTimer() {
    wall_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
    cpu_ += static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC;
  }
  RunTimer(const RunTimer&) = delete;
  RunTimer& operator=(const RunTimer&) = delete;

 private:
  double& wall_;
  double& cpu_;
  std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

}  // namespace detail

}  // namespace gmis
