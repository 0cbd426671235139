#pragma once

#include <cstdint>

#include "gmis/mis/scheme.hpp"

namespace gmis {

/// What a run is asked for. The merging radius is absolute here (scene units).
struct RenderSettings {
  std::uint64_t seed = 0;
  int max_depth = 16;          ///< edges of a path; 1 is light seen directly
  double radius = 0.0;         ///< merging radius of the first iteration
  double alpha = 2.0 / 3.0;    ///< r_i = r_1 i^((α−1)/2)
  double light_paths = 1.0;    ///< light trees per pixel
  Scheme scheme = Scheme::N3;  ///< how the children of a split vertex are drawn
  int rounds = 1;              ///< k: a vertex with N proposals has M = kN children
  int light_tree_budget = 20;  ///< samples a light tree may draw before it stops splitting [Liu, Algorithm 1]
};

}  // namespace gmis
