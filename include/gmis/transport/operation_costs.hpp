#pragma once

#include "gmis/result/counters.hpp"

namespace gmis {

/// What operations cost relative to each other, a ray being 1: fitted to the times of all integrators on five scenes (two
/// balls in a box to some hundred triangles) with the built-in scene. Only ratios matter, and what is chosen by them is
/// the same on every machine.
struct OperationCosts {
  double ray = 1.0;         ///< closest hit, with the vertex made from it
  double shadow_ray = 0.8;  ///< with the contribution that waits for it
  double connection = 0.3;  ///< two BSDFs and a weight, whether or not a ray follows
  double merge_query = 0.6;
  double merge = 0.45;
  double photon_stored = 0.15;  ///< kept and sorted into the grid
};

[[nodiscard]] constexpr double cost_of(const Counters& work, const OperationCosts& costs = {}) noexcept {
  return costs.ray * static_cast<double>(work.rays) + costs.shadow_ray * static_cast<double>(work.shadow_rays) +
         costs.connection * static_cast<double>(work.connections) +
         costs.merge_query * static_cast<double>(work.merge_queries) + costs.merge * static_cast<double>(work.merges) +
         costs.photon_stored * static_cast<double>(work.photons_stored);
}

}  // namespace gmis
