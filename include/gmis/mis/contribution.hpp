#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include "gmis/core/spectrum.hpp"
#include "gmis/mis/log_density.hpp"

namespace gmis {

/// A value given by the logarithm of its magnitude and its sign, for integrands outside the range
/// of T (the product of a hundred densities, say). Zero is −infinity. An integrand may return it
/// with any set of proposals.
template <std::floating_point T>
struct LogValue {
  T log_magnitude;  ///< natural logarithm of the magnitude
  T sign = T(1);    ///< +1 or −1
};

/// The magnitudes of LogValue are finite numbers or −infinity; everything else is finite when its
/// channels are.
template <std::floating_point T>
[[nodiscard]] inline bool is_finite(const LogValue<T>& value) noexcept {
  return value.log_magnitude < std::numeric_limits<T>::infinity() && value.sign - value.sign == T(0);
}

/// f / φ in the type A of the accumulator, for one channel of f.
template <std::floating_point A, std::floating_point F, std::floating_point T>
[[nodiscard]] inline A ratio(F f, T density) noexcept {
  return static_cast<A>(f) / static_cast<A>(density);
}

/// f / φ, where φ may be outside the range of A: in two halves, so that no step leaves it unless
/// the result does. Zero for f = 0, whatever φ.
template <std::floating_point A, std::floating_point F, std::floating_point T>
[[nodiscard]] inline A ratio(F f, LogDensity<T> density) noexcept {
  if (f == F(0)) return A(0);  // half may be infinite
  const A half = std::exp(static_cast<A>(density.log) * A(-0.5));
  return (static_cast<A>(f) * half) * half;
}

template <std::floating_point A, std::floating_point F, std::floating_point T>
[[nodiscard]] inline A ratio(LogValue<F> f, LogDensity<T> density) noexcept {
  return static_cast<A>(f.sign) * std::exp(static_cast<A>(f.log_magnitude) - static_cast<A>(density.log));
}

template <std::floating_point A, std::floating_point F, std::floating_point T>
[[nodiscard]] inline A ratio(LogValue<F> f, T density) noexcept {
  return ratio<A>(f, LogDensity<A>{std::log(static_cast<A>(density))});
}

/// A LogValue is summed as one plain number.
template <std::floating_point T>
struct SpectrumTraits<LogValue<T>> {
  using Scalar = T;
  static constexpr int channel_count = 1;
  static constexpr const LogValue<T>& channel(const LogValue<T>& value, int) noexcept { return value; }
};

/// True for zero, in either of its forms.
template <std::floating_point T>
[[nodiscard]] inline bool is_black(const LogValue<T>& value) noexcept {
  return value.sign == T(0) || value.log_magnitude == -std::numeric_limits<T>::infinity();
}

}  // namespace gmis
