#pragma once

#include <cstdint>
#include <optional>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/mis/scheme.hpp"
#include "gmis/transport/effects/path_class.hpp"
#include "gmis/transport/sample_counts.hpp"

namespace gmis {

/// How light trees split: not at all (`none`), or at every non-specular vertex while the budget of the tree lasts.
/// walk/split.hpp explains `budgeted` and `paper`.
enum class LightSplit : std::uint8_t { none, budgeted, paper };

/// Where light subpaths start: as the lights emit by their power (`power`), or guided to where their light is needed
/// (`learned`, emission/learn_emission.hpp), for scenes whose lights shine far beyond the picture.
enum class Emission : std::uint8_t { power, learned };

/// Numbers of samples at the vertices of camera subpaths: the same everywhere (`uniform`), or functions of the vertex, learned in
/// the first iterations and used where they are predicted to gain (`learned`, counts/count_learner.hpp).
enum class VertexCounts : std::uint8_t { uniform, learned };

/// Numbers of camera subpaths of a pixel: one everywhere (`uniform`), or functions of the pixel, learned in the first iterations and
/// used where they are predicted to gain (`learned`, counts/pixel_counts.hpp).
enum class PixelCounts : std::uint8_t { uniform, learned };

/// The settings of a run.
struct RenderSettings {
  SampleCounts counts;     ///< techniques and their numbers of samples, for example one of `gmis::integrators`
  std::uint64_t seed = 0;  ///< selects the random numbers of the run
  /// How numbers are drawn. With `sobol` the iterations of a replication are not independent of each other; error
  /// estimates must take replications as batches (`BatchMeans`). A pilot draws independent numbers.
  Sampler sampler = Sampler::independent;
  int max_depth = 16;            ///< greatest number of edges of a path; 1: light seen directly; at most 256
  std::optional<double> radius;  ///< r_1, times `SampleCounts::radius_factor`, in scene units; unset: 0.4 pixel widths
  double alpha = 2.0 / 3.0;      ///< r_i = r_1 i^((α−1)/2)
  Emission emission = Emission::power;  ///< `learned` needs lights that model `GuidableLight`
  VertexCounts vertex_counts =
      VertexCounts::uniform;  ///< `learned` takes the place of `SampleCounts::camera_children` above 1
  PixelCounts pixel_counts = PixelCounts::uniform;  ///< not together with learned `vertex_counts`
  LightSplit light_split = LightSplit::none;        ///< must be `none` for an engine that does not split light trees
  Scheme scheme = Scheme::N3;                       ///< MIS scheme that draws the children of a split vertex
  int rounds = 1;                                   ///< k: a split light vertex with N lobes has M = kN children
  int light_tree_budget = 20;  ///< samples that a light tree may draw before it stops splitting [Liu, Algorithm 1]
  /// When set, every path is classified and only paths of these classes are made.
  std::optional<PathClassSet> path_classes;
};

}  // namespace gmis
