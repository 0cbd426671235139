#pragma once

#include "gmis/result/counters.hpp"

namespace gmis {

/// Costs of operations relative to a closest-hit ray: a fit to the times of many counts on eighteen
/// scenes of the built-in scene type (two balls in a box to some thousand triangles;
/// `./run bench operation_costs`). A choice that uses these constants instead of measured times is
/// the same on every machine. Within a scene the predicted costs of different counts are off by a
/// twentieth, also with constants fitted to the other scenes.
struct OperationCosts {
  double ray = 1.0;            ///< one closest hit, with the vertex made from it
  double shadow_ray = 1.0;     ///< one visibility query, with the light sample before it and its contribution
  double connection = 0.1;     ///< two BSDF evaluations, without the visibility query
  double merge_query = 0.6;    ///< one search in the grid
  double merge = 0.4;          ///< one light vertex merged
  double photon_stored = 1.1;  ///< one light vertex stored and sorted into the grid
  double projection = 0.65;    ///< one light vertex projected onto the picture, without the visibility query
};

/// Assumed operations per second on one core, used to turn a time budget into iterations without
/// reading a clock.
inline constexpr double nominal_operations_per_second = 8e6;

/// The cost of counted work in rays.
[[nodiscard]] constexpr double cost_of(const Counters& work, const OperationCosts& costs = {}) noexcept {
  return costs.ray * static_cast<double>(work.rays) + costs.shadow_ray * static_cast<double>(work.shadow_rays) +
         costs.connection * static_cast<double>(work.connections) +
         costs.merge_query * static_cast<double>(work.merge_queries) + costs.merge * static_cast<double>(work.merges) +
         costs.photon_stored * static_cast<double>(work.photons_stored) +
         costs.projection * static_cast<double>(work.projections);
}

}  // namespace gmis
