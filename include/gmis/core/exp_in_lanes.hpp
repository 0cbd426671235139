#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "gmis/core/attributes.hpp"

namespace gmis {

/// e^x without a call and without a branch, so that compilers turn a loop over it into vector
/// instructions, those of plain x86-64 too. Within 1.5 units in the last place for x from −708 to
/// 709.78; 0 below −708, where e^x nears the denormal numbers; 0 or NaN for NaN. Without meaning
/// above 709.78.
///
/// x = n ln 2 + r with |r| ≤ ln 2/2, ln 2 in two parts [Cody, Waite 1980]; e^r by its Taylor
/// polynomial of degree 13, whose remainder is below 5e-18.
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr double exp_in_lanes(double x) noexcept {
  static_assert(std::numeric_limits<double>::is_iec559 && sizeof(double) == sizeof(std::uint64_t));
  constexpr double to_nearest = 0x1.8p52;  // added, it leaves the nearest integer in the low bits
  constexpr double ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;
  // All bits for x ≥ −708, none below: from the sign of the difference, since a choice between two
  // values would be a branch.
  const std::uint64_t in_range = (std::bit_cast<std::uint64_t>(x + 708.0) >> 63U) - 1U;
  const double inside = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & in_range);
  const double shifted = inside * 1.4426950408889634 + to_nearest;
  const double n = shifted - to_nearest;
  const double r = (inside - n * ln2_high) - n * ln2_low;
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * (r * r) + r;
  p = p + 1.0;
  // 2^n in two factors: n = 1024 has no power of its own.
  const double half_power = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 1022U) << 52U);
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(p * 2.0 * half_power) & in_range);
}

}  // namespace gmis
