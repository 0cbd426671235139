#pragma once

#include "gmis/result/counters.hpp"

namespace gmis {

/// What operations cost relative to each other, a ray being 1: fitted to the times of all integrators on five scenes (two
/// balls in a box to some hundred triangles) with the built-in scene. Only ratios matter, and what is chosen by them is
/// the same on every machine.
struct OperationCosts {
  double ray = 1.0;          ///< closest hit, with the vertex made from it
  double shadow_ray = 1.1;   ///< with the contribution that waits for it
  double connection = 0.15;  ///< two BSDFs and a weight, whether or not a ray follows
  double merge_query = 0.6;
  double merge = 2.0;
  double photon_stored = 0.5;  ///< kept and sorted into the grid
  /// What is done for one more child of a camera subpath costs so many times that, for its rays go anywhere.
  double further_child = 1.25;
};

/// About so many of these a second on one core: what a time stands for where no clock may be read.
inline constexpr double nominal_operations_per_second = 5e6;

[[nodiscard]] constexpr double cost_of(const Counters& work, const OperationCosts& costs = {}) noexcept {
  return costs.ray * static_cast<double>(work.rays) + costs.shadow_ray * static_cast<double>(work.shadow_rays) +
         costs.connection * static_cast<double>(work.connections) +
         costs.merge_query * static_cast<double>(work.merge_queries) + costs.merge * static_cast<double>(work.merges) +
         costs.photon_stored * static_cast<double>(work.photons_stored);
}

}  // namespace gmis
