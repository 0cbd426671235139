#pragma once

#include "gmis/core/attributes.hpp"

/// \file
/// Intended IEEE 754 arithmetic: divisions by ±0 that are meant to give ±infinity. They use the
/// function below, so that the sanitizer's check of division by zero stays on everywhere else.

namespace gmis {

/// `numerator / denominator` as IEEE 754 defines it: ±infinity for a zero denominator, NaN for 0/0.
template <class T>
GMIS_INTENDED_IEEE_DIVISION constexpr T ieee_divide(T numerator, T denominator) noexcept {
  return numerator / denominator;
}

}  // namespace gmis
