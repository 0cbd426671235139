#pragma once

#include <concepts>
#include <type_traits>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/contribution.hpp"

/// \file
/// The types that an integrand may return.

namespace gmis {

/// A type that estimates add up: a floating-point number, a GLM vector of them, a LogValue, or your
/// own type with `SpectrumTraits` (`Scalar`, `channel_count`, `channel(value, i)`), which needs
/// nothing else.
template <class F>
concept Summable = std::copyable<F> && requires(const F& f, int i) {
  typename SpectrumTraits<F>::Scalar;
  requires std::floating_point<typename SpectrumTraits<F>::Scalar>;
  requires(SpectrumTraits<F>::channel_count >= 1);
  SpectrumTraits<F>::channel(f, i);
};

/// The type in which results of f are added up: double for an integer and for a bool, else the type
/// of the result itself.
template <class F>
using SummedAs = std::conditional_t<std::integral<F>, double, F>;

/// The type in which the values of `Integrand` at an X are added up.
template <class Integrand, class X>
using SummandOf = SummedAs<
    std::remove_cvref_t<decltype(std::declval<std::remove_reference_t<Integrand>&>()(std::declval<const X&>()))>>;

/// An integrand for samples of type X.
template <class F, class X>
concept IntegrandOf = requires {
  requires Summable<SummandOf<F, X>>;
};

/// f(x), as it is added up.
template <class Integrand, class X>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr SummandOf<Integrand, X> value_of(Integrand& f, const X& x) {
  return static_cast<SummandOf<Integrand, X>>(f(x));
}

}  // namespace gmis
