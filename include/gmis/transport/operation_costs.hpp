#pragma once

#include "gmis/result/counters.hpp"

namespace gmis {

/// What operations cost relative to each other: nanoseconds on the machine that they were fitted on (see
/// docs/integrators.md). Only ratios matter, and choices that follow from them are the same on every machine.
struct OperationCosts {
  double ray = 350.0;         ///< closest hit, with the vertex made from it
  double shadow_ray = 220.0;  ///< with the contribution that waits for it
  double connection = 120.0;  ///< two BSDFs and a weight, whether or not a ray follows
  double merge_query = 150.0;
  double merge = 70.0;
  double photon_stored = 90.0;  ///< kept and sorted into the grid
};

[[nodiscard]] constexpr double cost_of(const Counters& work, const OperationCosts& costs = {}) noexcept {
  return costs.ray * static_cast<double>(work.rays) + costs.shadow_ray * static_cast<double>(work.shadow_rays) +
         costs.connection * static_cast<double>(work.connections) +
         costs.merge_query * static_cast<double>(work.merge_queries) + costs.merge * static_cast<double>(work.merges) +
         costs.photon_stored * static_cast<double>(work.photons_stored);
}

}  // namespace gmis
