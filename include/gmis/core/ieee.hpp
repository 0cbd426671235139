#pragma once

/// \file
/// Intended IEEE 754 arithmetic: the places where a division by ±0 is meant to give ±infinity.
/// They go through these functions so that a sanitizer can stay on everywhere else.

#if defined(__clang__) || defined(__GNUC__)
#define GMIS_INTENDED_IEEE_DIVISION __attribute__((no_sanitize("float-divide-by-zero")))
#else
#define GMIS_INTENDED_IEEE_DIVISION
#endif

namespace gmis {

/// `numerator / denominator` as IEEE 754 defines it, also for a zero denominator (±infinity, or NaN for 0/0).
template <class T>
GMIS_INTENDED_IEEE_DIVISION constexpr T ieee_divide(T numerator, T denominator) noexcept {
  return numerator / denominator;
}

}  // namespace gmis
