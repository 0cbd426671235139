#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/storage.hpp"

namespace gmis {

/// The choice of the proposals that share a group when only the size of the groups is given.
enum class GroupOrder : std::uint8_t {
  strided,     ///< group g of G has proposals g, g + G, g + 2G, …: neighbours in the set are told apart
  consecutive  ///< group g has proposals gP, gP + 1, …: neighbours stay together
};

/// A partition of N proposals into groups, for the partial deterministic mixture. Build it outside
/// the loop; one with a fixed `Capacity` never allocates and holds at most `Capacity` proposals.
template <std::size_t Capacity = dynamic_capacity>
class Groups {
 public:
  /// Groups of `group_size` (1 to N). Where that does not divide N: ⌈N / group_size⌉ groups,
  /// whose sizes differ by at most one. Size 1 makes the partial mixture scheme N1, size N makes it
  /// N3.
  /// Throws std::invalid_argument for other sizes.
  Groups(std::size_t proposal_count, std::size_t group_size, GroupOrder order = GroupOrder::strided)
      : proposal_count_(proposal_count) {
    require_argument(proposal_count > 0, "groups of no proposals: give at least one");
    require_argument(proposal_count <= std::numeric_limits<std::uint32_t>::max(), "groups of 2^32 proposals or more");
    require_argument(group_size > 0 && group_size <= proposal_count,
                     "the size of the groups must be at least 1 and at most the number of proposals");
    count_ = (proposal_count + group_size - 1) / group_size;
    prepare(count_);
    std::size_t slot = 0;
    for (std::size_t group = 0; group < count_; ++group) {
      const std::size_t larger = proposal_count % count_;  // groups with one proposal more than the others
      const std::size_t size = proposal_count / count_ + (group < larger ? 1 : 0);
      first_[group] = static_cast<std::uint32_t>(slot);
      for (std::size_t i = 0; i < size; ++i, ++slot)
        members_[slot] = static_cast<std::uint32_t>(order == GroupOrder::strided ? group + i * count_ : slot);
    }
    first_[count_] = static_cast<std::uint32_t>(slot);
  }

  /// Any partition: `group_of[i]` is the number of the group that proposal i belongs to. Groups are
  /// numbered from 0, and none is empty. Throws std::invalid_argument for other numbers.
  explicit Groups(std::span<const std::uint32_t> group_of) : proposal_count_(group_of.size()) {
    require_argument(proposal_count_ > 0, "groups of no proposals: give at least one");
    for (const std::uint32_t group : group_of) {
      require_argument(group < proposal_count_, "groups are numbered from 0, without gaps: a number is too large");
      count_ = std::max<std::size_t>(count_, group + std::size_t{1});
    }
    prepare(count_);
    std::size_t slot = 0;
    for (std::size_t group = 0; group < count_; ++group) {
      first_[group] = static_cast<std::uint32_t>(slot);
      for (std::size_t i = 0; i < group_of.size(); ++i)
        if (group_of[i] == group) members_[slot++] = static_cast<std::uint32_t>(i);
      require_argument(slot > first_[group], "groups are numbered from 0, without gaps: a group is empty");
    }
    first_[count_] = static_cast<std::uint32_t>(slot);
  }

  [[nodiscard]] std::size_t proposal_count() const noexcept { return proposal_count_; }
  /// The number of groups.
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  /// The proposals of a group, held by this object.
  [[nodiscard]] std::span<const std::uint32_t> members(std::size_t group) const& noexcept {
    return {members_.data() + first_[group], std::size_t{first_[group + 1]} - first_[group]};
  }
  std::span<const std::uint32_t> members(std::size_t group) const&& = delete;  // it would end with the groups
  /// Throws std::invalid_argument unless these are groups of `proposal_count` proposals.
  constexpr void require_fits(std::size_t proposal_count) const {
    require_argument(proposal_count == proposal_count_, "the groups are those of another number of proposals");
  }
  /// Evaluations of densities in one round: Σ P_g², so N P for groups of P.
  [[nodiscard]] std::size_t density_evaluations_per_round() const noexcept {
    std::size_t sum = 0;
    for (std::size_t group = 0; group < count_; ++group) sum += members(group).size() * members(group).size();
    return sum;
  }

 private:
  void prepare(std::size_t group_count) {
    members_.prepare(proposal_count_);
    first_.prepare(group_count + 1);
  }

  static constexpr std::size_t bounds = Capacity == dynamic_capacity ? dynamic_capacity : Capacity + 1;
  std::size_t proposal_count_;
  std::size_t count_ = 0;
  Storage<std::uint32_t, Capacity> members_;  // group by group
  Storage<std::uint32_t, bounds> first_;      // where each group begins, and the end
};

}  // namespace gmis
