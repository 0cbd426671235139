#pragma once

#include <vector>

#include "support/render.hpp"

namespace gmis::tools {

/// Edges of the paths that a technique makes. A merged vertex counts on both sides.
[[nodiscard]] int edges_of(const TechniqueId& id);

/// All techniques side by side, the pyramid by which weights are judged: a row per path length
/// (edges, shortest on top); on the left the connections by their number s of light vertices (0:
/// emitter hit, 1: next event, the last: splat), on the right the merges. Each image is labelled
/// with s and t, `m` before a merge; one that no path was made for is missing. Images are made
/// larger or smaller by whole factors, to be about 100 pixels wide.
[[nodiscard]] Image technique_sheet(const std::vector<TechniqueImage>& techniques, bool is_weighted);

/// All path classes side by side, at most five in a row, in the order of their numbers.
[[nodiscard]] Image class_sheet(const std::vector<ClassImage>& classes);

}  // namespace gmis::tools
