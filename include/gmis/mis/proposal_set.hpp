#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/log_density.hpp"
#include "gmis/mis/proposal.hpp"
#include "gmis/mis/storage.hpp"

/// \file
/// A set of N proposals, seen in one way whatever it is made of: an array, a vector or span, a
/// tuple of different types, or a type of the user's own.

namespace gmis {

/// One density of the i-th proposal: `pdf(i, x)` or `log_pdf(i, x)`.
template <class S>
concept SetHasPdf = requires(const S& s, const typename S::Value& x) {
  { s.pdf(std::size_t{}, x) } -> std::floating_point;
};
template <class S>
concept SetHasLogPdf = requires(const S& s, const typename S::Value& x) {
  { s.log_pdf(std::size_t{}, x) } -> std::floating_point;
};
/// All densities at once: `pdfs(x, out)` or `log_pdfs(x, out)` fill `out`, a span of `size()`
/// numbers of type `Density`.
template <class S>
concept SetHasPdfs = requires(const S& s, const typename S::Value& x, std::span<typename S::Density> out) {
  s.pdfs(x, out);
};
template <class S>
concept SetHasLogPdfs = requires(const S& s, const typename S::Value& x, std::span<typename S::Density> out) {
  s.log_pdfs(x, out);
};

/// The set that rounds work on. Your own type can have these members in place of a container of
/// proposals:
/// - `Value`, `Density`: the type of a sample, and the floating-point type of a density;
/// - `size()`: N; and, if N has a bound known at compile time,
///   `static constexpr std::size_t capacity`;
/// - `sample(i, source)`: a Value, or an optional one, from proposal i;
/// - `pdf(i, x)`, or all at once `pdfs(x, out)`, or both; or the same with logarithms:
///   `log_pdf(i, x)`, `log_pdfs(x, out)`.
template <class S, class Source = Philox>
concept ProposalSet = requires(const S& s, Source& source) {
  typename S::Value;
  requires std::floating_point<typename S::Density>;
  { s.size() } -> std::convertible_to<std::size_t>;
  s.sample(std::size_t{}, source);
}
&&(SetHasPdf<S> || SetHasLogPdf<S> || SetHasPdfs<S> || SetHasLogPdfs<S>);

/// True when the densities of the set are handled as logarithms.
template <class S>
inline constexpr bool is_log_set = SetHasLogPdf<S> || SetHasLogPdfs<S>;

/// N, when it or a bound on it is known at compile time, else `dynamic_capacity`.
template <class S>
inline constexpr std::size_t capacity_of = [] {
  if constexpr (requires { S::capacity; })
    return static_cast<std::size_t>(S::capacity);
  else
    return dynamic_capacity;
}();

/// The density type of one proposal.
template <class P, class X>
struct DensityOf;
template <class P, class X>
requires HasLogPdf<P, X>
struct DensityOf<P, X> {
  using Type = std::remove_cvref_t<decltype(std::declval<const P&>().log_pdf(std::declval<const X&>()))>;
};
/// The result of `pdf`.
template <class P, class X>
requires(HasPdf<P, X> && !HasLogPdf<P, X>) struct DensityOf<P, X> {
  /// The density type.
  using Type = std::remove_cvref_t<decltype(std::declval<const P&>().pdf(std::declval<const X&>()))>;
};

/// `Count` proposals of one type side by side in memory, by reference; a sample is an X.
template <class P, std::size_t Count = dynamic_capacity, class X = ValueOf<P>>
class ProposalSpan {
 public:
  using Value = X;
  using Density = typename DensityOf<P, Value>::Type;
  static constexpr std::size_t capacity = Count;

  /// A view of proposals side by side, which must outlive it.
  constexpr ProposalSpan(const P* proposals, std::size_t size) noexcept : proposals_(proposals), size_(size) {}

  /// The number of proposals.
  [[nodiscard]] constexpr std::size_t size() const noexcept {
    if constexpr (Count == dynamic_capacity)
      return size_;
    else
      return Count;
  }
  /// A sample of proposal i.
  template <class Source>
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr auto sample(std::size_t i, Source& source) const {
    return proposals_[i].sample(source);
  }
  /// The density of proposal i at x.
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr Density pdf(std::size_t i, const Value& x) const
      requires(!HasLogPdf<P, Value>) {
    return proposals_[i].pdf(x);
  }
  /// The logarithm of the density of proposal i at x.
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr Density log_pdf(std::size_t i,
                                                             const Value& x) const requires HasLogPdf<P, Value> {
    return proposals_[i].log_pdf(x);
  }

 private:
  const P* proposals_;
  std::size_t size_;
};

/// Proposals of different types, by reference. All make the same type X of sample; densities meet
/// in their common type.
template <class X, class... P>
class ProposalTuple {
 public:
  using Value = X;
  using Density = std::common_type_t<typename DensityOf<P, Value>::Type...>;
  static constexpr std::size_t capacity = sizeof...(P);
  /// One of them states logarithms.
  static constexpr bool any_log = (HasLogPdf<P, Value> || ...);

  /// A view of the tuple, which must outlive it.
  explicit constexpr ProposalTuple(const std::tuple<P...>& proposals) noexcept : proposals_(&proposals) {}
  explicit ProposalTuple(const std::tuple<P...>&&) = delete;  // it would refer to a temporary

  /// The number of proposals.
  [[nodiscard]] constexpr std::size_t size() const noexcept { return sizeof...(P); }

  /// A sample of proposal i.
  template <class Source>
  [[nodiscard]] constexpr auto sample(std::size_t i, Source& source) const {
    constexpr bool can_fail =
        (SampleResult<decltype(std::declval<const P&>().sample(std::declval<Source&>()))>::can_fail || ...);
    using Result = std::conditional_t<can_fail, std::optional<Value>, Value>;
    return visit<Result>(i, [&](const auto& proposal) -> Result { return proposal.sample(source); });
  }
  /// The density of proposal i at x.
  [[nodiscard]] constexpr Density pdf(std::size_t i, const Value& x) const requires(!any_log) {
    return visit<Density>(i, [&](const auto& proposal) { return static_cast<Density>(proposal.pdf(x)); });
  }
  [[nodiscard]] constexpr Density log_pdf(std::size_t i, const Value& x) const requires any_log {
    return visit<Density>(i, [&](const auto& proposal) { return log_pdf_of(proposal, x); });
  }
  constexpr void pdfs(const Value& x, std::span<Density> out) const requires(!any_log) {
    std::apply(
        [&](const auto&... proposal) {
          std::size_t i = 0;
          ((out[i++] = static_cast<Density>(proposal.pdf(x))), ...);
        },
        *proposals_);
  }
  constexpr void log_pdfs(const Value& x, std::span<Density> out) const requires any_log {
    std::apply(
        [&](const auto&... proposal) {
          std::size_t i = 0;
          ((out[i++] = log_pdf_of(proposal, x)), ...);
        },
        *proposals_);
  }

 private:
  template <class Q>
  [[nodiscard]] static constexpr Density log_pdf_of(const Q& proposal, const Value& x) {
    if constexpr (HasLogPdf<Q, Value>)
      return static_cast<Density>(proposal.log_pdf(x));
    else
      return static_cast<Density>(std::log(proposal.pdf(x)));
  }

  template <class Result, std::size_t K = 0, class F>
  [[nodiscard]] constexpr Result visit(std::size_t i, F&& f) const {
    if constexpr (K + 1 == sizeof...(P)) {
      return f(std::get<K>(*proposals_));
    } else {
      return i == K ? f(std::get<K>(*proposals_)) : visit<Result, K + 1>(i, f);
    }
  }

  const std::tuple<P...>* proposals_;
};

/// Something whose items lie side by side in memory: what std::span can refer to.
template <class R>
concept SideBySide = requires(const R& items) {
  std::span(items);
};
/// The proposal that a range holds.
template <class R>
using ItemOf = typename decltype(std::span(std::declval<const R&>()))::value_type;

/// Tuples whose items are all proposals of one type of value, for this source.
template <class T, class Source>
inline constexpr bool is_tuple_of_proposals = false;
template <class First, class... P, class Source>
requires AnyProposal<First, Source>
inline constexpr bool is_tuple_of_proposals<std::tuple<First, P...>, Source> =
    (Proposal<P, ValueOf<First, Source>, Source> && ...);

namespace detail {
template <class Source, ProposalSet<Source> S>
[[nodiscard]] constexpr const S& see_as_set(const S& proposals) noexcept {
  return proposals;
}
template <class Source, class First, class... P>
requires is_tuple_of_proposals<std::tuple<First, P...>, Source>
[[nodiscard]] constexpr auto see_as_set(const std::tuple<First, P...>& proposals) noexcept {
  return ProposalTuple<ValueOf<First, Source>, First, P...>(proposals);
}
template <class Source, class P, std::size_t N>
requires AnyProposal<P, Source>
[[nodiscard]] constexpr auto see_as_set(const std::array<P, N>& proposals) noexcept {
  return ProposalSpan<P, N, ValueOf<P, Source>>(proposals.data(), N);
}
template <class Source, SideBySide R>
requires(!ProposalSet<R, Source> && AnyProposal<ItemOf<R>, Source>)
    [[nodiscard]] constexpr auto see_as_set(const R& proposals) noexcept {
  const std::span items(proposals);
  using P = ItemOf<R>;
  return ProposalSpan<P, dynamic_capacity, ValueOf<P, Source>>(items.data(), items.size());
}
}  // namespace detail

/// std::array, std::vector, std::span or std::tuple of proposals, or a type that meets
/// `ProposalSet`, for this source.
template <class S, class Source = Philox>
concept Proposals = requires(const S& s) {
  detail::see_as_set<Source>(s);
};

/// Sees anything accepted as a set of proposals as a `ProposalSet` that draws from a `Source`.
/// Containers and tuples are referred to, not copied: they must outlive the set, so that
/// temporaries are refused.
template <class Source = Philox, Proposals<Source> S>
[[nodiscard]] constexpr decltype(auto) as_proposal_set(const S& proposals) noexcept {
  return detail::see_as_set<Source>(proposals);
}

/// A temporary that owns its proposals: not a span, which only refers to them.
template <class R>
concept OwningTemporary = !std::is_lvalue_reference_v<R> && !requires {
  typename std::remove_cvref_t<R>::element_type;
  requires std::same_as<std::remove_cvref_t<R>,
                        std::span<typename std::remove_cvref_t<R>::element_type, std::remove_cvref_t<R>::extent>>;
};
template <class Source = Philox, OwningTemporary R>
requires Proposals<R, Source>
auto as_proposal_set(R&& proposals)
    -> decltype(detail::see_as_set<Source>(proposals)) = delete;  // it would refer to a temporary: give that a name

}  // namespace gmis
