#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "gmis/transport/engine/engine.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/family.hpp"
#include "support/seed.hpp"
#include "support/series.hpp"

/// \file
/// Two scenes that are to have the same picture, rendered independently.

namespace gmis_test {

/// Means of square tiles and three channels, iteration by iteration. Tiles are usually of 8 × 8
/// pixels: in smaller ones rare bright samples make a mean that has other tails than Student's t.
struct TileMeans {
  std::vector<double> mean, squares;
  std::size_t count = 0;
  Series picture;  ///< the mean of all of them

  void add(const std::vector<double>& values) {
    if (mean.empty()) mean.resize(values.size()), squares.resize(values.size());
    ++count;
    picture.add(std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()));
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
TileMeans tiles_of(const Sc& scene, const gmis::SampleCounts& counts, std::uint64_t seed, int iterations,
                   int side = 8) {
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
    for (int y = 0; y + side <= size.y; y += side)
      for (int x = 0; x + side <= size.x; x += side)
        for (int c = 0; c < 3; ++c) {
          double sum = 0;
          for (int v = 0; v < side; ++v)
            for (int u = 0; u < side; ++u)
              sum += static_cast<double>(engine.frame()[static_cast<std::size_t>((y + v) * size.x + x + u)][c]);
          values.push_back(sum / (side * side));
        }
    tiles.add(values);
  }
  return tiles;
}

/// Every tile of both has the same mean, and so has the picture. One false alarm in a million runs
/// for all tiles together, one in ten thousand for the picture, which sees a difference of 10 % and
/// mostly one of 5 %. Student's t with the iterations of both (Welch's degrees of freedom are at
/// least those of one).
inline void check_same_picture(const TileMeans& a, const TileMeans& b) {
  REQUIRE(a.mean.size() == b.mean.size());
  Family tiles(1e-6, a.mean.size()), picture(1e-4, 1);
  const std::size_t count = std::min(a.count, b.count);
  for (std::size_t i = 0; i < a.mean.size(); ++i) {
    const double error = std::hypot(a.standard_error(i), b.standard_error(i));
    INFO("tile value " << i << ": " << a.mean[i] << " and " << b.mean[i] << ", standard error " << error);
    CHECK(gmis::t_test(a.mean[i] - b.mean[i], error, count, 0.0).passes(tiles.level()));
  }
  const double error = std::hypot(a.picture.standard_error(), b.picture.standard_error());
  INFO("the picture: " << a.picture.mean() << " and " << b.picture.mean() << ", standard error " << error);
  const double by_chance = picture.limit(count) * error;
  CHECK(std::abs(a.picture.mean() - b.picture.mean()) <= by_chance);
  CHECK(a.picture.mean() > 0);
  CHECK(by_chance < 0.1 * a.picture.mean());
  CHECK(tiles.is_complete());
}

}  // namespace gmis_test
