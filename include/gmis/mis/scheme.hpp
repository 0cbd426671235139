#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "gmis/core/argument_error.hpp"

namespace gmis {

/// How the index of the proposal behind the n-th sample of a round is chosen [Elvira S1–S3].
enum class Selection : std::uint8_t {
  S1,  ///< at random, with replacement
  S2,  ///< at random, without replacement: every round is an independent permutation
  S3   ///< deterministic, without replacement: index n mod N
};

/// The density φ_n that the n-th sample is divided by [Elvira W1–W5]. The estimate is the mean of
/// f(x_n) / φ_n(x_n).
enum class Weighting : std::uint8_t {
  W1,  ///< density of x_n given the indices drawn before it: the mixture of the proposals that could still be drawn
  W2,  ///< density of x_n given its own index: q_j
  W3,  ///< marginal density of x_n
  W4,  ///< mixture of the indices that were really drawn in this round
  W5   ///< the mixture ψ of all proposals
};

/// The six schemes that the fifteen pairs of Selection and Weighting come down to.
enum class Scheme : std::uint8_t { R1, R2, R3, N1, N2, N3 };

inline constexpr std::array all_selections{Selection::S1, Selection::S2, Selection::S3};
inline constexpr std::array all_weightings{Weighting::W1, Weighting::W2, Weighting::W3, Weighting::W4, Weighting::W5};
inline constexpr std::array all_schemes{Scheme::R1, Scheme::R2, Scheme::R3, Scheme::N1, Scheme::N2, Scheme::N3};

/// Throws std::invalid_argument for a number that is no enumerator.
constexpr void require_enumerator(Scheme scheme) {
  require_argument(static_cast<std::size_t>(scheme) < all_schemes.size(), "this is no gmis::Scheme: R1 to N3");
}
/// Throws std::invalid_argument for a number that is no enumerator.
constexpr void require_enumerator(Selection selection, Weighting weighting) {
  require_argument(static_cast<std::size_t>(selection) < all_selections.size(), "this is no gmis::Selection: S1 to S3");
  require_argument(static_cast<std::size_t>(weighting) < all_weightings.size(), "this is no gmis::Weighting: W1 to W5");
}

/// The scheme that a pair comes down to [Elvira, table 2]. Throws std::invalid_argument for a
/// number that is no enumerator.
[[nodiscard]] constexpr Scheme scheme_of(Selection selection, Weighting weighting) {
  require_enumerator(selection, weighting);
  constexpr Scheme table[3][5] = {{Scheme::R3, Scheme::R1, Scheme::R3, Scheme::R2, Scheme::R3},
                                  {Scheme::N2, Scheme::N1, Scheme::N3, Scheme::N3, Scheme::N3},
                                  {Scheme::N1, Scheme::N1, Scheme::N1, Scheme::N3, Scheme::N3}};
  return table[static_cast<std::size_t>(selection)][static_cast<std::size_t>(weighting)];
}

/// A pair of selection and weighting, which makes a scheme.
struct SelectionAndWeighting {
  Selection selection;  ///< which proposal makes a sample
  Weighting weighting;  ///< what it is divided by
  friend constexpr bool operator==(SelectionAndWeighting, SelectionAndWeighting) = default;
};

/// The pair that a scheme is run as: the one of its pairs that spends the fewest random numbers.
[[nodiscard]] constexpr SelectionAndWeighting cheapest_pair(Scheme scheme) {
  require_enumerator(scheme);
  switch (scheme) {
    case Scheme::R1:
      return {Selection::S1, Weighting::W2};
    case Scheme::R2:
      return {Selection::S1, Weighting::W4};
    case Scheme::R3:
      return {Selection::S1, Weighting::W5};
    case Scheme::N1:
      return {Selection::S3, Weighting::W2};
    case Scheme::N2:
      return {Selection::S2, Weighting::W1};
    case Scheme::N3:
      break;
  }
  return {Selection::S3, Weighting::W5};
}

/// True for the schemes that are unbiased only when *every* proposal is positive wherever the
/// integrand is not zero. R3 and N3 need it of the mixture alone.
[[nodiscard]] constexpr bool needs_full_support(Scheme scheme) noexcept {
  return scheme != Scheme::R3 && scheme != Scheme::N3;
}

/// The scheme to use in place of `scheme` when the proposals cover the integrand only together: R3
/// or N3.
[[nodiscard]] constexpr Scheme safe_for_partial_support(Scheme scheme) noexcept {
  const bool with_replacement = scheme == Scheme::R1 || scheme == Scheme::R2 || scheme == Scheme::R3;
  return with_replacement ? Scheme::R3 : Scheme::N3;
}

/// Evaluations of proposal densities in one round of N samples from N proposals, a sample's own
/// density included. For R2 it depends on the draw: N times the number of distinct indices,
/// `distinct_indices`.
[[nodiscard]] constexpr std::size_t density_evaluations_per_round(Scheme scheme, std::size_t proposal_count,
                                                                  std::size_t distinct_indices = 0) {
  require_enumerator(scheme);
  switch (scheme) {
    case Scheme::R1:
    case Scheme::N1:
      return proposal_count;
    case Scheme::R2:
      return proposal_count * distinct_indices;
    case Scheme::N2:
      return proposal_count * (proposal_count + 1) / 2;
    case Scheme::R3:
    case Scheme::N3:
      break;
  }
  return proposal_count * proposal_count;
}

[[nodiscard]] constexpr std::string_view name_of(Scheme scheme) {
  require_enumerator(scheme);
  constexpr std::string_view names[] = {"R1", "R2", "R3", "N1", "N2", "N3"};
  return names[static_cast<std::size_t>(scheme)];
}
[[nodiscard]] constexpr std::string_view name_of(Selection selection) {
  require_enumerator(selection, Weighting::W1);
  constexpr std::string_view names[] = {"S1", "S2", "S3"};
  return names[static_cast<std::size_t>(selection)];
}
[[nodiscard]] constexpr std::string_view name_of(Weighting weighting) {
  require_enumerator(Selection::S1, weighting);
  constexpr std::string_view names[] = {"W1", "W2", "W3", "W4", "W5"};
  return names[static_cast<std::size_t>(weighting)];
}

/// Turns a scheme known at run time into one known at compile time: calls
/// `f(std::integral_constant<Scheme, …>{})` and returns what it returns. One branch, to be taken
/// outside the loop. Throws std::invalid_argument for a number that is no enumerator.
template <class F>
constexpr decltype(auto) dispatch(Scheme scheme, F&& f) {
  require_enumerator(scheme);
  switch (scheme) {
    case Scheme::R1:
      return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::R1>{});
    case Scheme::R2:
      return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::R2>{});
    case Scheme::R3:
      return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::R3>{});
    case Scheme::N1:
      return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::N1>{});
    case Scheme::N2:
      return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::N2>{});
    case Scheme::N3:
      break;
  }
  return std::forward<F>(f)(std::integral_constant<Scheme, Scheme::N3>{});
}

/// `dispatch` for a pair: calls
/// `f(std::integral_constant<Selection, …>{}, std::integral_constant<Weighting, …>{})`.
template <class F>
constexpr decltype(auto) dispatch(Selection selection, Weighting weighting, F&& f) {
  require_enumerator(selection, weighting);
  const auto with_selection = [&]<Selection s>(std::integral_constant<Selection, s> fixed) -> decltype(auto) {
    switch (weighting) {
      case Weighting::W1:
        return f(fixed, std::integral_constant<Weighting, Weighting::W1>{});
      case Weighting::W2:
        return f(fixed, std::integral_constant<Weighting, Weighting::W2>{});
      case Weighting::W3:
        return f(fixed, std::integral_constant<Weighting, Weighting::W3>{});
      case Weighting::W4:
        return f(fixed, std::integral_constant<Weighting, Weighting::W4>{});
      case Weighting::W5:
        break;
    }
    return f(fixed, std::integral_constant<Weighting, Weighting::W5>{});
  };
  switch (selection) {
    case Selection::S1:
      return with_selection(std::integral_constant<Selection, Selection::S1>{});
    case Selection::S2:
      return with_selection(std::integral_constant<Selection, Selection::S2>{});
    case Selection::S3:
      break;
  }
  return with_selection(std::integral_constant<Selection, Selection::S3>{});
}

}  // namespace gmis
