#pragma once

#include <concepts>

#include "gmis/core/concepts.hpp"

namespace gmis {

/// Number of children of the vertices of light subpaths.
///
/// - `Settings`: the settings of the policy; `P(settings)` constructs it.
/// - `nominal_children(bsdf)`: c of a light subpath at a vertex, without the continuation
///   probability. It is a function of the vertex alone, because a subpath from the other end of the
///   path knows nothing else about the vertex, and constant while weights are formed.
/// - `is_measured`: true when `nominal_children` is measured over separate trees: `Tally` counts
///   vertices and the children drawn there, and `freeze(tally)` takes the means.
template <class P, class B>
concept SplitPolicy = Bsdf<B> && requires(P& policy, const P& frozen, const B& bsdf, typename P::Tally& tally) {
  P(typename P::Settings{});
  { P::is_measured } -> std::convertible_to<bool>;
  { frozen.nominal_children(bsdf) } -> std::convertible_to<double>;
  tally += tally;
  policy.freeze(tally);
};

/// Light subpaths are paths: c = 1. Models `SplitPolicy`.
template <std::floating_point T>
struct NoSplit {
  struct Settings {};  ///< there is nothing to set
  /// Counts nothing.
  struct Tally {
    /// Does nothing.
    constexpr Tally& operator+=(const Tally&) noexcept { return *this; }
  };
  static constexpr bool is_measured = false;  ///< c is known

  /// There is nothing to set.
  constexpr explicit NoSplit(Settings) noexcept {}
  /// c = 1 at every vertex.
  template <Bsdf B>
  [[nodiscard]] static constexpr T nominal_children(const B&) noexcept {
    return T(1);
  }
  /// Does nothing, since c is known.
  static constexpr void freeze(const Tally&) noexcept {}
};

}  // namespace gmis
