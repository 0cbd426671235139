#pragma once

#include <algorithm>
#include <cmath>

#include "gmis/check/findings.hpp"
#include "gmis/core/spectrum.hpp"

namespace gmis::detail {

/// Equal but for rounding: relative to the larger one, or both negligible.
[[nodiscard]] inline bool nearly(double a, double b, double tolerance = 0.01, double negligible = 1e-12) noexcept {
  const double scale = std::max(std::abs(a), std::abs(b));
  return scale <= negligible || std::abs(a - b) <= tolerance * scale;
}

/// Counts whether two numbers are equal but for rounding.
inline void compare(Findings& findings, Convention convention, double found, double wanted, double tolerance = 0.01) {
  findings.count(convention, nearly(found, wanted, tolerance), found, wanted);
}

/// Counts whether `found` equals `wanted` · `factor` in every channel, but for rounding and for a
/// thousandth of the largest channel. The example shows a channel that differs.
template <Spectrum S>
void compare_channels(Findings& findings, Convention convention, const S& found, const S& wanted, double factor,
                      double tolerance) {
  const auto channel = [](const S& s, int i) { return static_cast<double>(SpectrumTraits<S>::channel(s, i)); };
  double largest = 0.0;
  for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i)
    largest = std::max({largest, std::abs(channel(found, i)), std::abs(channel(wanted, i) * factor)});
  int shown = 0;
  bool holds = true;
  for (int i = 0; i < SpectrumTraits<S>::channel_count && holds; ++i) {
    shown = i;
    holds = nearly(channel(found, i), channel(wanted, i) * factor, tolerance, 1e-3 * largest);
  }
  findings.count(convention, holds, channel(found, shown), channel(wanted, shown) * factor);
}

}  // namespace gmis::detail
