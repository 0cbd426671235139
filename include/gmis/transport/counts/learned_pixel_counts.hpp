#pragma once

#include <algorithm>
#include <cstdint>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/counts/learned_table.hpp"
#include "gmis/transport/counts/pixel_count_learner.hpp"
#include "gmis/transport/counts/pixel_counts.hpp"

namespace gmis {

/// The numbers of camera subpaths of a run.
using LearnedPixelCounts = LearnedTable<PixelCountLearner, PixelCountTable>;

/// The camera subpaths of an iteration (from 1).
[[nodiscard]] inline PixelSchedule schedule_of(const LearnedPixelCounts& counts, std::uint32_t iteration) noexcept {
  const std::uint64_t rounds = iteration > 0 ? (iteration - 1) / sobol_replications : 0;
  if (!counts.is_on()) return {nullptr, 1, 0, rounds};
  if (counts.is_learning()) return {nullptr, PixelCountLearner::subpaths, rounds, 0};
  // Of the same replication, the iterations before the numbers were known.
  const std::uint32_t first = iteration - static_cast<std::uint32_t>(rounds) * sobol_replications;
  const std::uint64_t before =
      first > counts.known_after() ? 0 : (counts.known_after() - first) / sobol_replications + 1;
  return {counts.table(), 1, before, rounds - std::min(before, rounds)};
}

}  // namespace gmis
