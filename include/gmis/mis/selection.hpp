#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/scheme.hpp"

namespace gmis {

/// Chooses the proposal of each sample of one round. `workspace.order` is for the weighting: for S2
/// a permutation whose entries from n on are still undrawn, for R2 all indices of the round. For R2
/// `workspace.multiplicity[i]` counts how often i was drawn; for N2 with unequal allocation, how
/// often it can still be.
template <Selection selection, Scheme scheme, class AllocationType, UniformSource Source, class WorkspaceType>
class IndexSelector {
  static constexpr bool draws_all_first = scheme == Scheme::R2;
  static constexpr bool counts_undrawn = scheme == Scheme::N2 && !AllocationType::is_equal;
  using Count = typename WorkspaceType::Count;

 public:
  /// Prepares the choices of one round.
  GMIS_ALWAYS_INLINE IndexSelector(const AllocationType& allocation, Source& source, WorkspaceType& workspace,
                                   std::size_t proposal_count, std::size_t sample_count)
      : allocation_(allocation),
        source_(source),
        workspace_(workspace),
        proposal_count_(proposal_count),
        sample_count_(sample_count) {
    if constexpr (selection == Selection::S2)
      for (std::size_t n = 0; n < sample_count; ++n)
        workspace_.order[n] = static_cast<std::uint32_t>(allocation.proposal_of_slot(n));
    if constexpr (draws_all_first || counts_undrawn)
      for (std::size_t i = 0; i < proposal_count; ++i) workspace_.multiplicity[i] = Count(0);
    if constexpr (draws_all_first)
      for (std::size_t n = 0; n < sample_count; ++n) {
        const std::size_t i = allocation.draw(source, proposal_count);
        workspace_.order[n] = static_cast<std::uint32_t>(i);
        workspace_.multiplicity[i] += Count(1);
      }
    if constexpr (counts_undrawn)
      for (std::size_t n = 0; n < sample_count; ++n) workspace_.multiplicity[workspace_.order[n]] += Count(1);
  }

  /// The index of sample n; to be called for n = 0, 1, … in order.
  [[nodiscard]] GMIS_ALWAYS_INLINE std::size_t next(std::size_t n) {
    if constexpr (selection == Selection::S3) {
      return allocation_.proposal_of_slot(n);
    } else if constexpr (draws_all_first) {
      return workspace_.order[n];
    } else if constexpr (selection == Selection::S1) {
      return allocation_.draw(source_, proposal_count_);
    } else {
      const std::size_t undrawn = sample_count_ - n;
      const std::size_t chosen = undrawn == 1 ? n : n + uniform_index(source_, static_cast<std::uint32_t>(undrawn));
      std::swap(workspace_.order[n], workspace_.order[chosen]);
      return workspace_.order[n];
    }
  }

  /// Says that sample n is done with: its index no longer counts as undrawn.
  GMIS_ALWAYS_INLINE void discard(std::size_t n) {
    if constexpr (counts_undrawn) workspace_.multiplicity[workspace_.order[n]] -= Count(1);
  }

 private:
  const AllocationType& allocation_;
  Source& source_;
  WorkspaceType& workspace_;
  std::size_t proposal_count_;
  std::size_t sample_count_;
};

}  // namespace gmis
