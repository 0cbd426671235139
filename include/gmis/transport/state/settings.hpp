#pragma once

#include <cstdint>
#include <optional>

#include "gmis/core/sobol_numbers.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/sample_counts.hpp"

namespace gmis {

/// Start of light subpaths: by the power of the lights (`power`), or guided to where their light is
/// needed (`learned`, emission/learn_lights.hpp), for scenes whose lights shine far beyond the
/// picture.
enum class Emission : std::uint8_t { power, learned };

/// The settings of a run.
struct RenderSettings {
  SampleCounts counts;     ///< techniques and their numbers of samples, for example one of `gmis::integrators`
  std::uint64_t seed = 0;  ///< selects the random numbers of the run
  /// The kind of random numbers. With `sobol` the iterations of a replication are not independent
  /// of each other; error estimates must take replications as batches (`BatchMeans`). A pilot draws
  /// independent numbers.
  Sampler sampler = Sampler::independent;
  int max_depth = 16;            ///< greatest number of edges of a path; 1: light seen directly; at most 256
  std::optional<double> radius;  ///< r_1 / `SampleCounts::radius_factor`, in scene units; unset: 0.4 pixel widths
  double alpha = 2.0 / 3.0;      ///< r_i = r_1 i^((α−1)/2)
  Emission emission = Emission::power;  ///< `learned` needs lights that model `GuidableLight`
  /// When set, every path is classified and only paths of these classes are made.
  std::optional<PathClassSet> path_classes;
};

}  // namespace gmis
