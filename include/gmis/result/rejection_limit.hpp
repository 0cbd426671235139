#pragma once

#include <cmath>

#include "gmis/result/counters.hpp"

namespace gmis {

/// How much may be rejected before a picture cannot be trusted: a few samples lost to rounding are harmless, many mean
/// that something is wrong with the scene or with the code that describes it.
struct RejectionLimit {
  double share = 1e-4;  ///< of the contributions; infinite: any number

  [[nodiscard]] bool is_exceeded(const Counters& counters) const noexcept {
    return static_cast<double>(counters.rejected()) > allowed(counters);
  }

  /// Whether it is exceeded by more than chance: five standard deviations of a Poisson count. Then a run need not go on;
  /// one that is near the limit is decided at its end.
  [[nodiscard]] bool is_surely_exceeded(const Counters& counters) const noexcept {
    const auto rejected = static_cast<double>(counters.rejected());
    return rejected - 5.0 * std::sqrt(rejected) > allowed(counters);
  }

 private:
  /// With no contribution at all nothing may be rejected, unless everything may.
  [[nodiscard]] double allowed(const Counters& counters) const noexcept {
    return std::isinf(share) ? share : share * static_cast<double>(counters.contributions);
  }
};

}  // namespace gmis
