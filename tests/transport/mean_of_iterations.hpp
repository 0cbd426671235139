#pragma once

#include <algorithm>
#include <cmath>

#include "gmis/core/concepts.hpp"
#include "gmis/core/spectrum.hpp"
#include "gmis/result/counters.hpp"

namespace gmis_test {

/// The mean of a picture over pixels and channels.
struct Mean {
  double value = 0;
  double standard_error = 0;  ///< from the spread of the iterations
  gmis::Counters counters;    ///< of all iterations
};

/// Renders `iterations` iterations, at least 2, with a gmis::Engine or a gmis::AnyEngine.
template <class Engine>
[[nodiscard]] Mean mean_of_iterations(Engine& engine, int iterations) {
  gmis::SerialExecutor executor;
  double sum = 0, squares = 0;
  for (int i = 0; i < iterations; ++i) {
    engine.iterate(executor);
    double mean = 0;
    for (const auto& pixel : engine.frame())
      mean += static_cast<double>(gmis::mean_channel(pixel)) / static_cast<double>(engine.frame().size());
    sum += mean / iterations;
    squares += mean * mean / iterations;
  }
  return {sum, std::sqrt(std::max(0.0, squares - sum * sum) / (iterations - 1)), engine.counters()};
}

}  // namespace gmis_test
