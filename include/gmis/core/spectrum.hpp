#pragma once

// Under -ffast-math the compiler takes every number for finite and removes the tests that keep NaN
// out of the film.
#if defined(__FAST_MATH__) && !defined(GMIS_ALLOW_FAST_MATH)
#error "gmis: -ffast-math removes the tests for NaN; compile without it, or define GMIS_ALLOW_FAST_MATH"
#endif

#include <algorithm>
#include <cmath>
#include <concepts>
#include <glm/vec3.hpp>

namespace gmis {

/// The interface through which the library reads a spectrum. It is specialised for a floating-point
/// number and for GLM vectors of them (RGB is `glm::vec3`). For another type, specialise it with
/// the same three members. Without a specialisation there are no channels, and the type is no
/// `Spectrum`; its scalar counts as float, so that the compiler complains once, where a concept is
/// asked for, and not at every mention of the type.
template <class S>
struct SpectrumTraits {
  using Scalar = float;
};

/// A floating-point number: one channel.
template <std::floating_point T>
struct SpectrumTraits<T> {
  using Scalar = T;
  static constexpr int channel_count = 1;
  static constexpr T channel(T s, int) noexcept { return s; }
};

/// A GLM vector: N channels.
template <int N, std::floating_point T, glm::qualifier Q>
struct SpectrumTraits<glm::vec<N, T, Q>> {
  using Scalar = T;
  static constexpr int channel_count = N;
  static constexpr T channel(const glm::vec<N, T, Q>& s, int i) noexcept { return s[i]; }
};

template <class S>
using ScalarOf = typename SpectrumTraits<S>::Scalar;

/// A type whose `SpectrumTraits<S>::channel_count` channels can be read.
template <class S>
concept HasChannels = std::copyable<S> && requires(const S& s, int i) {
  { SpectrumTraits<S>::channel(s, i) } -> std::convertible_to<ScalarOf<S>>;
};

/// Light in channels: a vector space with a channel-wise product.
template <class S>
concept Spectrum = HasChannels<S> && requires(const S& s, S m, ScalarOf<S> scalar) {
  { s + s } -> std::convertible_to<S>;
  { s* s } -> std::convertible_to<S>;
  { s* scalar } -> std::convertible_to<S>;
  {m += s};
  {S(scalar)};
};

template <Spectrum S>
[[nodiscard]] constexpr ScalarOf<S> max_channel(const S& s) noexcept {
  ScalarOf<S> largest = SpectrumTraits<S>::channel(s, 0);
  for (int i = 1; i < SpectrumTraits<S>::channel_count; ++i)
    largest = std::max(largest, SpectrumTraits<S>::channel(s, i));
  return largest;
}

template <Spectrum S>
[[nodiscard]] constexpr ScalarOf<S> min_channel(const S& s) noexcept {
  ScalarOf<S> smallest = SpectrumTraits<S>::channel(s, 0);
  for (int i = 1; i < SpectrumTraits<S>::channel_count; ++i)
    smallest = std::min(smallest, SpectrumTraits<S>::channel(s, i));
  return smallest;
}

template <Spectrum S>
[[nodiscard]] constexpr ScalarOf<S> channel_sum(const S& s) noexcept {
  ScalarOf<S> sum = SpectrumTraits<S>::channel(s, 0);
  for (int i = 1; i < SpectrumTraits<S>::channel_count; ++i) sum += SpectrumTraits<S>::channel(s, i);
  return sum;
}
template <Spectrum S>
[[nodiscard]] constexpr ScalarOf<S> mean_channel(const S& s) noexcept {
  return channel_sum(s) / static_cast<ScalarOf<S>>(SpectrumTraits<S>::channel_count);
}

/// True when every channel is zero.
template <HasChannels S>
[[nodiscard]] constexpr bool is_black(const S& s) noexcept {
  for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i)
    if (SpectrumTraits<S>::channel(s, i) != ScalarOf<S>(0)) return false;
  return true;
}

/// True when every channel is finite.
template <HasChannels S>
[[nodiscard]] inline bool is_finite(const S& s) noexcept {
  // x − x is 0 for a finite x and NaN otherwise, so one sum tests all channels.
  ScalarOf<S> sum(0);
  for (int i = 0; i < SpectrumTraits<S>::channel_count; ++i) {
    const ScalarOf<S> channel = SpectrumTraits<S>::channel(s, i);
    sum += channel - channel;
  }
  return sum == ScalarOf<S>(0);
}

}  // namespace gmis
