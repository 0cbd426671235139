#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "gmis/mis/storage.hpp"

namespace gmis {

/// Working memory of a round: the order of its indices, how often each occurs, and the densities at
/// one point. Keep one per thread and pass it to `sample_round`. One with a fixed `Capacity` lives
/// on the stack and never allocates; a dynamic one allocates when a round is larger than any before
/// it.
template <std::floating_point T, std::size_t Capacity>
class Workspace {
 public:
  static constexpr std::size_t capacity = Capacity;
  using Count = T;  ///< counts are factors of densities: kept in their type, so that none is converted in the loop

  /// Makes room; allocates only where there is less than is needed.
  void prepare(std::size_t proposal_count, std::size_t sample_count) {
    order.prepare(sample_count);
    multiplicity.prepare(proposal_count);
    densities.prepare(proposal_count);
  }

  Storage<std::uint32_t, Capacity> order;  ///< proposal index of each sample
  Storage<Count, Capacity> multiplicity;   ///< times that a proposal occurs, a whole number
  Storage<T, Capacity> densities;          ///< of all proposals at one point
};

}  // namespace gmis
