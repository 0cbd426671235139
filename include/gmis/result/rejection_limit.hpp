#pragma once

#include <cmath>

#include "gmis/result/counters.hpp"

namespace gmis {

/// The greatest share of rejections that a trustworthy picture may have. Rounding causes a few
/// rejections, which are harmless. More rejections indicate an error in the scene or in the code
/// that describes it.
struct RejectionLimit {
  double share = 1e-4;  ///< rejections allowed per contribution; infinity allows any number

  /// True when a finished run has more rejections than the limit allows.
  [[nodiscard]] bool is_exceeded(const Counters& counters) const noexcept {
    return static_cast<double>(counters.rejected()) > allowed(counters);
  }

  /// True when a running render exceeds the limit by more than five standard deviations of a
  /// Poisson count. The run can then be stopped. A run near the limit is judged at its end by
  /// `is_exceeded`.
  [[nodiscard]] bool is_surely_exceeded(const Counters& counters) const noexcept {
    const auto rejected = static_cast<double>(counters.rejected());
    return rejected - 5.0 * std::sqrt(rejected) > allowed(counters);
  }

 private:
  /// Allowed number of rejections; 0 without contributions, unless `share` is infinite.
  [[nodiscard]] double allowed(const Counters& counters) const noexcept {
    return std::isinf(share) ? share : share * static_cast<double>(counters.contributions);
  }
};

}  // namespace gmis
