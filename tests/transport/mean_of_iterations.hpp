#pragma once

#include "gmis/core/concepts.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"
#include "support/series.hpp"

namespace gmis_test {

/// The mean of a picture over pixels and channels.
struct Mean {
  double value = 0;
  double standard_error = 0;  ///< from the spread of the iterations
  gmis::Counters counters;    ///< of all iterations
};

/// The mean of one picture over pixels and channels.
template <class Frame>
[[nodiscard]] double mean_of_pixels(const Frame& frame) {
  double mean = 0;
  for (const auto& pixel : frame)
    mean += static_cast<double>(gmis::mean_channel(pixel)) / static_cast<double>(frame.size());
  return mean;
}

/// Renders `iterations` iterations with a gmis::Engine or a gmis::AnyEngine: the mean of each.
template <class Engine>
[[nodiscard]] Series means_of_iterations(Engine& engine, int iterations) {
  gmis::SerialExecutor executor;
  Series means;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    means.add(mean_of_pixels(engine.frame()));
  }
  return means;
}

/// Renders `iterations` iterations, at least 2: their mean, and what the engine counted.
template <class Engine>
[[nodiscard]] Mean mean_of_iterations(Engine& engine, int iterations) {
  const Series means = means_of_iterations(engine, iterations);
  return {means.mean(), means.standard_error(), engine.counters()};
}

}  // namespace gmis_test
