#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"

namespace gmis {

/// A partition of the proposals into groups of `group_size` (sizes that differ by at most one, as
/// `Groups` has them) that makes the variance of the partial deterministic mixture small at the
/// same cost [Elvira, Martino, Luengo, Bugallo: Heretical multiple importance sampling, 2016]: from
/// the better of strided and consecutive groups, pairs of proposals change places as long as that
/// gains. A local minimum. The partition is chosen before the samples that use it are drawn, from a
/// quadrature rule or a `PilotSamples`, so that estimates stay unbiased; a partition chosen by the
/// samples themselves would bias.
///
/// Partitions that do not cover f are not considered. Throws std::invalid_argument for a size
/// outside 1 to N, and when the search meets no partition that covers f.
[[nodiscard]] inline Groups<> best_groups(const TabulatedProblem& problem, std::size_t group_size) {
  const std::size_t n = problem.proposal_count();
  if (group_size == 0 || group_size > n) reject_argument("the group size must lie between 1 and N");
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto variance_of = [&](const std::vector<std::uint32_t>& group_of) {
    const Groups<> groups{std::span<const std::uint32_t>(group_of)};
    if (!has_full_support(groups, problem)) return infinity;
    const double variance = exact_moments(groups, problem).variance;
    return variance < infinity ? variance : infinity;
  };
  std::vector<std::uint32_t> best(n);
  double least = infinity;
  for (const GroupOrder order : {GroupOrder::strided, GroupOrder::consecutive}) {
    const Groups<> groups(n, group_size, order);
    std::vector<std::uint32_t> group_of(n);
    for (std::size_t g = 0; g < groups.size(); ++g)
      for (const std::uint32_t k : groups.members(g)) group_of[k] = static_cast<std::uint32_t>(g);
    double variance = variance_of(group_of);
    for (bool gained = true; gained;) {
      gained = false;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = a + 1; b < n; ++b) {
          if (group_of[a] == group_of[b]) continue;
          std::swap(group_of[a], group_of[b]);
          const double other = variance_of(group_of);
          if (other < variance * (1.0 - 1e-12) || (variance == infinity && other < infinity)) {
            variance = other;
            gained = true;
          } else {
            std::swap(group_of[a], group_of[b]);
          }
        }
    }
    if (variance < least) {
      least = variance;
      best = group_of;
    }
  }
  if (least == infinity) reject_argument("no partition into groups of this size covers the integrand");
  return Groups<>{std::span<const std::uint32_t>(best)};
}

}  // namespace gmis
