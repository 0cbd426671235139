#pragma once

#include <concepts>
#include <optional>
#include <type_traits>
#include <utility>

#include "gmis/core/random.hpp"

/// \file
/// The members that a proposal (a sampling technique with a known density) must have.

namespace gmis {

/// The result of `sample`: an X, or an `std::optional<X>` from a proposal that can fail to make a
/// sample.
template <class R>
struct SampleResult {
  using Value = R;
  /// `sample` always makes one.
  static constexpr bool can_fail = false;
};
/// The result of `sample` of a proposal that may return nothing.
template <class X>
struct SampleResult<std::optional<X>> {
  using Value = X;
  /// `sample` may make none.
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
/// - `sample(source)`: an X distributed with the density; or an `std::optional<X>`, empty when no
///   sample was made. An empty one counts as a zero contribution, so the density must then
///   integrate to the probability of success.
/// - `pdf(x)`: the density at x, with respect to any measure that all proposals of a set share; it
///   must be positive and finite at the proposal's own samples. Or `log_pdf(x)`, where densities
///   may leave the range of the type: when one proposal of a set has it, the weights of the set are
///   formed with log-sum-exp.
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

/// \cond
// Never defined; core/missing_members.hpp says what these are for.
// clang-format off
namespace proposal_lacks {
template <class P, class Source> struct sample;  // X sample(Source&) const
template <class P, class X> struct value;        // `sample` must return X, or std::optional<X>
template <class P, class X> struct pdf;          // double pdf(const X&) const, or float, long double; or log_pdf
}  // namespace proposal_lacks
// clang-format on

namespace detail {
template <class P, class X, class Source>
consteval auto proposal_verdict() {
  if constexpr (Proposal<P, X, Source>)
    return std::type_identity<std::true_type>();
  else if constexpr (!requires(const P& p, Source& source) { p.sample(source); })
    return std::type_identity<proposal_lacks::sample<P, Source>>();
  else if constexpr (!HasSample<P, X, Source>)
    return std::type_identity<proposal_lacks::value<P, X>>();
  else
    return std::type_identity<proposal_lacks::pdf<P, X>>();
}
}  // namespace detail
/// \endcond

/// `IsProposal<P, X>()` is true where `gmis::Proposal<P, X, Source>` holds; else the compiler's
/// first line names what is missing.
template <class P, class X, class Source = Philox>
using IsProposal = typename decltype(detail::proposal_verdict<P, X, Source>())::type;

}  // namespace gmis
