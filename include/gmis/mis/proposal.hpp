#pragma once

#include <concepts>
#include <optional>
#include <type_traits>
#include <utility>

#include "gmis/core/random.hpp"

/// \file
/// What a proposal (a sampling technique with a known density) has to offer.

namespace gmis {

/// What `sample` returns: an X, or an `std::optional<X>` by a proposal that can fail to make a sample.
template <class R>
struct SampleResult {
  using Value = R;
  static constexpr bool can_fail = false;
};
template <class X>
struct SampleResult<std::optional<X>> {
  using Value = X;
  static constexpr bool can_fail = true;
};

/// `p.pdf(x)`: a floating-point density at x.
template <class P, class X>
concept HasPdf = requires(const P& p, const X& x) {
  { p.pdf(x) } -> std::floating_point;
};

/// `p.log_pdf(x)`: the natural logarithm of the density at x, −infinity where the density is zero.
template <class P, class X>
concept HasLogPdf = requires(const P& p, const X& x) {
  { p.log_pdf(x) } -> std::floating_point;
};

/// `p.sample(source)` makes an X, or an `std::optional<X>`.
template <class P, class X, class Source = Philox>
concept HasSample = requires(const P& p, Source& source) {
  requires std::same_as<typename SampleResult<decltype(p.sample(source))>::Value, X>;
};

/// A sampling technique for values of type X (a number, a vector, a direction, any type of yours).
///
/// - `sample(source)`: an X distributed with the density; or an `std::optional<X>`, empty when no sample was made. An
///   empty one counts as a zero contribution, so the density must then integrate to the probability of success.
/// - `pdf(x)`: the density at x, with respect to any measure that all proposals of a set share; it must be positive and
///   finite at the proposal's own samples. Or `log_pdf(x)`, where densities may leave the range of the type: when one
///   proposal of a set has it, the weights of the set are formed with log-sum-exp.
template <class P, class X, class Source = Philox>
concept Proposal = HasSample<P, X, Source> &&(HasPdf<P, X> || HasLogPdf<P, X>);

/// The X of a proposal.
template <class P, class Source = Philox>
using ValueOf = typename SampleResult<
    std::remove_cvref_t<decltype(std::declval<const P&>().sample(std::declval<Source&>()))>>::Value;

template <class P, class Source = Philox>
concept AnyProposal = requires(const P& p, Source& source) {
  p.sample(source);
}
&&Proposal<P, ValueOf<P, Source>, Source>;

}  // namespace gmis
