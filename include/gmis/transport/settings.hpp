#pragma once

#include <cstdint>
#include <optional>

#include "gmis/mis/scheme.hpp"
#include "gmis/transport/effects/path_class.hpp"
#include "gmis/transport/sample_counts.hpp"

namespace gmis {

/// How light trees split: not at all, or at every non-specular vertex while the tree's budget lasts (walk/split.hpp).
enum class LightSplit : std::uint8_t { none, budgeted, paper };

/// What a run is asked for.
struct RenderSettings {
  SampleCounts counts;  ///< which techniques run, and how often; one of `gmis::integrators`, for example
  std::uint64_t seed = 0;
  int max_depth = 16;            ///< edges of a path; 1 is light seen directly
  std::optional<double> radius;  ///< merging radius of the first iteration in scene units; unset: 0.4 pixel widths
  double alpha = 2.0 / 3.0;      ///< r_i = r_1 i^((α−1)/2)
  LightSplit light_split = LightSplit::none;  ///< read by engines that split light trees
  Scheme scheme = Scheme::N3;                 ///< how the children of a split vertex are drawn
  int rounds = 1;                             ///< k: a light vertex with N lobes has M = kN children
  int light_tree_budget = 20;  ///< samples a light tree may draw before it stops splitting [Liu, Algorithm 1]
  /// Set: the class of every path is known, and only paths of these classes are made.
  std::optional<PathClassSet> path_classes;
};

}  // namespace gmis
