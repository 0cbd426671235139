#pragma once

#include <cstddef>
#include <span>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/mixture.hpp"
#include "gmis/mis/proposal_set.hpp"

namespace gmis {

/// A set whose size became known at run time, seen as one of at most `Bound` proposals (of exactly
/// one, if `Bound` is 1): what a round writes in is then on the stack, and its loop is compiled for
/// few proposals. Holds a small set by value, another by reference.
template <class Set, std::size_t Bound>
class BoundedSet {
 public:
  using Value = typename Set::Value;
  using Density = typename Set::Density;
  static constexpr std::size_t capacity = Bound;

  /// `set.size()` must be at most `Bound`.
  explicit constexpr BoundedSet(const Set& set) noexcept : set_(set) {}
  explicit BoundedSet(const Set&&) = delete;  // it would refer to a temporary

  /// Number of proposals, at most `Bound`.
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr std::size_t size() const noexcept {
    if constexpr (Bound == 1)
      return 1;
    else
      return set_.size();
  }
  /// Draws a sample of proposal `i`.
  template <class Source>
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr auto sample(std::size_t i, Source& source) const {
    return set_.sample(i, source);
  }
  /// Density of proposal `i` at `x`, in the measure of the set.
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr Density pdf(std::size_t i, const Value& x) const requires SetHasPdf<Set> {
    return set_.pdf(i, x);
  }
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr Density log_pdf(std::size_t i,
                                                             const Value& x) const requires SetHasLogPdf<Set> {
    return set_.log_pdf(i, x);
  }
  constexpr void pdfs(const Value& x, std::span<Density> out) const requires SetHasPdfs<Set> { set_.pdfs(x, out); }
  constexpr void log_pdfs(const Value& x, std::span<Density> out) const requires SetHasLogPdfs<Set> {
    set_.log_pdfs(x, out);
  }

 private:
  PassedAs<Set> set_;
};

/// Calls `run(set)` once, with the set itself where the number of proposals is bounded at compile
/// time or large, else with it as a `BoundedSet` of one or of few.
template <class Set, class Run>
GMIS_ALWAYS_INLINE inline void with_bound(const Set& set, Run&& run) {
  if constexpr (capacity_of<Set> == dynamic_capacity) {
    if (set.size() == 1) return run(BoundedSet<Set, 1>(set));
    if (set.size() <= few_densities) return run(BoundedSet<Set, few_densities>(set));
  }
  run(set);
}

}  // namespace gmis
