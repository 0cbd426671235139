#pragma once

#include "gmis/transport/engine/method.hpp"
#include "gmis/transport/splitting/light_tree.hpp"
#include "gmis/transport/splitting/queue_split.hpp"

/// \file
/// The GMIS path sampler [Liu, Algorithm 1]: `Engine<Scene, SplitTrees>`, with the settings
/// `GmisSampler`. Only gmis_engines.hpp includes this header.

namespace gmis {

/// Light subpaths are trees: each vertex may have several children.
struct LightTrees {
  template <std::floating_point T>
  using Split = QueueSplit<T>;
  /// Traces a light tree.
  template <class Context, class Output>
  using Walk = LightTree<Context, Output>;
};

/// All techniques; light trees branch.
using SplitTrees = Method<RecursiveWeights<BalanceRatio>, FilmOutput, LightTrees>;

}  // namespace gmis
