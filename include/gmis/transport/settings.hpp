#pragma once

#include <cstdint>

#include "gmis/mis/scheme.hpp"
#include "gmis/transport/path_class.hpp"

namespace gmis {

/// How many stored light vertices a camera vertex is connected with, when not a number of one's own.
enum Connections : int {
  paired_connections = 0,     ///< every vertex of one light tree: the tree with the number of the pixel
  measured_connections = -1,  ///< 1, 2 or 4 from the cache of all trees, as the first iterations say
};

/// What a run is asked for. The merging radius is absolute here (scene units).
struct RenderSettings {
  std::uint64_t seed = 0;
  int max_depth = 16;        ///< edges of a path; 1 is light seen directly
  double radius = 0.0;       ///< merging radius of the first iteration
  double alpha = 2.0 / 3.0;  ///< r_i = r_1 i^((α−1)/2)
  double light_paths = 1.0;  ///< light trees per pixel
  int connections =
      measured_connections;    ///< light vertices drawn from the cache per camera vertex, or a `Connections`
  Scheme scheme = Scheme::N3;  ///< how the children of a split vertex are drawn
  int rounds = 1;              ///< k: a vertex with N proposals has M = kN children
  int light_tree_budget = 20;  ///< samples a light tree may draw before it stops splitting [Liu, Algorithm 1]
  int camera_children = 1;     ///< of the first non-specular camera vertex, where the policy splits at all
  PathClassSet path_classes = PathClassSet::all();  ///< what is rendered; read by integrators that are `Classified`
  bool adapts_split = false;  ///< numbers of children follow measured variance × cost, then stay as they are
};

}  // namespace gmis
