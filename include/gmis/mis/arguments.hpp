#pragma once

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include "gmis/mis/integrand.hpp"
#include "gmis/mis/proposal_set.hpp"

/// \file
/// The compiler's message about arguments that cannot serve: one sentence, for the first thing that
/// is missing.

namespace gmis::detail {

enum class Fault {
  none,
  source,
  no_items,
  several_values,
  not_side_by_side,
  single_proposal,
  incomplete_set,
  not_a_set,
  pointers,
  sample_not_const,
  no_sample,
  no_value,
  pdf_not_const,
  no_pdf,
  density_not_real,
  integrand_not_callable,
  integrand_value
};

/// `Result` for arguments without a fault; else the compiler stops with the sentence. A function
/// that returns one is explained at the line that calls it.
template <Fault fault, class Result>
struct Explained : Result {
  static_assert(
      fault != Fault::source,
      "the source must be a random engine that is not const: gmis::Philox, an engine of <random>, or any class "
      "that meets std::uniform_random_bit_generator");
  static_assert(fault != Fault::no_items, "the set of proposals is empty: give it at least one");
  static_assert(fault != Fault::several_values, "all proposals of a set must make the same type of sample");
  static_assert(fault != Fault::not_side_by_side,
                "proposals must lie side by side in memory: in a std::array, std::vector or std::span");
  static_assert(fault != Fault::single_proposal,
                "this is one proposal and not a set of them: pass std::array{proposal}");
  static_assert(fault != Fault::incomplete_set,
                "your own set needs `Value`, `Density` (float, double or long double), and const members `size()`, "
                "`sample(i, source)` and one of `pdf(i, x)`, `pdfs(x, out)`, `log_pdf(i, x)`, `log_pdfs(x, out)`");
  static_assert(fault != Fault::not_a_set,
                "proposals must be a std::array, std::vector, std::span or std::tuple of them, or a type that meets "
                "gmis::ProposalSet");
  static_assert(fault != Fault::pointers,
                "this set holds pointers to proposals: it must hold the proposals themselves, or a type of yours whose "
                "`sample` and `pdf` call what it points to");
  static_assert(fault != Fault::sample_not_const, "`sample(source)` of a proposal must be const");
  static_assert(fault != Fault::no_sample, "a proposal has no `sample(source)` that takes this source");
  static_assert(fault != Fault::no_value, "`sample(source)` of a proposal must return the sample");
  static_assert(fault != Fault::pdf_not_const, "`pdf(x)` of a proposal must be const");
  static_assert(fault != Fault::no_pdf,
                "a proposal has no `pdf(x)` (or `log_pdf(x)`) that takes what its `sample` makes");
  static_assert(fault != Fault::density_not_real, "`pdf(x)` of a proposal must return float, double or long double");
  static_assert(fault != Fault::integrand_not_callable,
                "the integrand f(x) does not take what the proposals' `sample` makes");
  static_assert(
      fault != Fault::integrand_value,
      "the integrand must return a number, a GLM vector of floating-point numbers, a gmis::LogValue, or a type "
      "with gmis::SpectrumTraits");
};

/// True without a fault; else the compiler stops with the sentence.
template <Fault fault>
consteval bool explain() {
  if constexpr (fault == Fault::none) {
    return true;
  } else {
    struct Nothing {};
    return sizeof(Explained<fault, Nothing>) == 0;
  }
}

template <class P, class X>
concept HasAnyPdf = requires(P& p, const X& x) {
  p.pdf(x);
}
|| requires(P& p, const X& x) {
  p.log_pdf(x);
};

/// The first thing that a proposal lacks.
template <class P, class Source>
consteval Fault fault_of_proposal() {
  if constexpr (AnyProposal<P, Source>) {
    return Fault::none;
  } else if constexpr (requires(const P& p) { *p; }) {
    return Fault::pointers;
  } else if constexpr (!requires(P & p, Source & source) { p.sample(source); }) {
    return Fault::no_sample;
  } else if constexpr (!requires(const P& p, Source& source) { p.sample(source); }) {
    return Fault::sample_not_const;
  } else if constexpr (std::is_void_v<decltype(std::declval<const P&>().sample(std::declval<Source&>()))>) {
    return Fault::no_value;
  } else if constexpr (!HasAnyPdf<P, ValueOf<P, Source>>) {
    return Fault::no_pdf;
  } else if constexpr (!HasAnyPdf<const P, ValueOf<P, Source>>) {
    return Fault::pdf_not_const;
  } else {
    return Fault::density_not_real;
  }
}

template <class T>
inline constexpr bool is_tuple = false;
template <class... P>
inline constexpr bool is_tuple<std::tuple<P...>> = true;

template <class Source, class... P>
consteval Fault fault_of_tuple(const std::tuple<P...>*) {
  if constexpr (sizeof...(P) == 0) {
    return Fault::no_items;
  } else {
    Fault first = Fault::none;
    static_cast<void>((((first = fault_of_proposal<P, Source>()) != Fault::none) || ...));
    return first == Fault::none ? Fault::several_values : first;
  }
}

/// The first thing that a set of proposals lacks.
template <class P, class Source>
consteval Fault fault_of_set() {
  if constexpr (Proposals<P, Source>) {
    return Fault::none;
  } else if constexpr (is_tuple<P>) {
    return fault_of_tuple<Source>(static_cast<const P*>(nullptr));
  } else if constexpr (SideBySide<P>) {
    return fault_of_proposal<ItemOf<P>, Source>();
  } else if constexpr (requires(const P& p) { p.begin() != p.end(); }) {
    return Fault::not_side_by_side;
  } else if constexpr (AnyProposal<P, Source>) {
    return Fault::single_proposal;
  } else if constexpr (requires { typename P::Density; }) {
    return Fault::incomplete_set;
  } else {
    return Fault::not_a_set;
  }
}

/// The first fault of the arguments of an estimate.
template <class Integrand, class P, class Source>
consteval Fault fault_of_arguments() {
  using F = std::remove_reference_t<Integrand>;
  using S = std::remove_reference_t<Source>;
  if constexpr (!UniformSource<S>) {
    return Fault::source;
  } else if constexpr (fault_of_set<P, S>() != Fault::none) {
    return fault_of_set<P, S>();
  } else {
    using X = typename std::remove_cvref_t<decltype(as_proposal_set<S>(std::declval<const P&>()))>::Value;
    if constexpr (!requires(F & f, const X& x) { f(x); })
      return Fault::integrand_not_callable;
    else
      return IntegrandOf<F, X> ? Fault::none : Fault::integrand_value;
  }
}

/// True for the arguments of an estimate; else the compiler stops with one sentence.
template <class Integrand, class P, class Source>
consteval bool explain_arguments() {
  return explain<fault_of_arguments<Integrand, P, Source>()>();
}

}  // namespace gmis::detail
