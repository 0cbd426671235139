#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

/// \file
/// Two scenes that are to have the same picture, rendered independently.

namespace gmis_test {

/// Means of tiles of 4 × 4 pixels and three channels, iteration by iteration.
struct TileMeans {
  std::vector<double> mean, squares;
  std::size_t count = 0;

  void add(const std::vector<double>& values) {
    if (mean.empty()) mean.resize(values.size()), squares.resize(values.size());
    ++count;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double difference = values[i] - mean[i];
      mean[i] += difference / static_cast<double>(count);
      squares[i] += difference * (values[i] - mean[i]);
    }
  }
  [[nodiscard]] double standard_error(std::size_t i) const {
    const double n = static_cast<double>(count);
    return std::sqrt(squares[i] / (n * (n - 1.0)));
  }
};

/// `Engine`: one of the engines of the library, for the scene's type.
template <class Engine, gmis::Scene Sc>
TileMeans tiles_of(const Sc& scene, const gmis::SampleCounts& counts, std::uint64_t seed, int iterations) {
  gmis::RenderSettings settings;
  settings.counts = counts;
  settings.max_depth = 6;
  settings.seed = gmis_test::seed(seed);
  Engine engine(scene, settings);
  gmis::SerialExecutor executor;
  TileMeans tiles;
  const glm::ivec2 size = scene.camera().resolution();
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    std::vector<double> values;
    for (int y = 0; y + 4 <= size.y; y += 4)
      for (int x = 0; x + 4 <= size.x; x += 4)
        for (int c = 0; c < 3; ++c) {
          double sum = 0;
          for (int v = 0; v < 4; ++v)
            for (int u = 0; u < 4; ++u)
              sum += static_cast<double>(engine.frame()[static_cast<std::size_t>((y + v) * size.x + x + u)][c]);
          values.push_back(sum / 16);
        }
    tiles.add(values);
  }
  return tiles;
}

/// Every tile of both has the same mean. One false alarm in a million runs for all tiles together;
/// Student's t with the iterations of both (Welch's degrees of freedom are at least those of one).
inline void check_same_picture(const TileMeans& a, const TileMeans& b) {
  REQUIRE(a.mean.size() == b.mean.size());
  const double level = gmis::sidak_level(1e-6, a.mean.size());
  double light = 0;
  for (std::size_t i = 0; i < a.mean.size(); ++i) {
    const double error = std::hypot(a.standard_error(i), b.standard_error(i));
    light += a.mean[i];
    INFO("tile value " << i << ": " << a.mean[i] << " and " << b.mean[i] << ", standard error " << error);
    CHECK(gmis::t_test(a.mean[i] - b.mean[i], error, std::min(a.count, b.count), 0.0).passes(level));
  }
  CHECK(light > 0);
}

}  // namespace gmis_test
