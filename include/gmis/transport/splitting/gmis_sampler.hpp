#pragma once

#include <cstdint>

#include "gmis/mis/scheme.hpp"

namespace gmis {

/// The end of the budget of a light tree.
enum class TreeBudget : std::uint8_t {
  softened,  ///< vertices then have one child each: unbiased
  cut        ///< the queue is dropped, as printed [Liu, Algorithm 1]: loses energy, kept for comparison
};

/// The settings of the GMIS path sampler [Liu, Algorithm 1]: light trees that split at every
/// non-specular vertex.
struct GmisSampler {
  Scheme scheme = Scheme::N3;  ///< MIS scheme that draws the children of a vertex
  int rounds = 1;              ///< k: a vertex with N lobes has M = kN children; at most 1024
  int budget = 20;             ///< samples that a light tree may draw before it stops splitting
  /// How a tree goes on when its budget is spent.
  TreeBudget at_end_of_budget = TreeBudget::softened;
};

}  // namespace gmis
