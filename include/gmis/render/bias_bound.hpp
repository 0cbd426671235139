#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "gmis/transport/render_engine.hpp"

namespace gmis {

/// Upper confidence bound of the bias of merging in the mean of `iterations` iterations, relative as
/// `ErrorEstimate::relative_error`, from what a pilot has measured (`Forecast::squared_bias_bound`). Light that the pilot has
/// not met is not in it.
/// 0 where nothing merges; empty where something merges and no pilot has finished. `counts`: of the latest iteration.
///
/// With P pilot iterations, whose disk is the largest of all candidates, and the bias c r² of one iteration to first
/// order, r_i² = r_1² i^(α−1), the bias of the mean of N iterations is
///     (P b_pilot + b_chosen Σ_{i=P+1}^{N} i^(α−1) / mean_{i ≤ M} i^(α−1)) / N,
/// where a forecast's bias b is that of the mean disk of the M iterations that the choice is made for.
[[nodiscard]] inline std::optional<double> bias_bound(const std::optional<Choice>& choice, const SampleCounts& counts,
                                                      double alpha, std::uint32_t iterations) {
  if (!choice) return counts.has(Technique::merge) ? std::nullopt : std::optional(0.0);
  if (iterations == 0) return 0.0;
  double pilot_bias = 0.0;
  for (const Forecast& forecast : choice->forecasts)
    pilot_bias = std::max(pilot_bias, std::sqrt(forecast.squared_bias_bound));
  const std::uint32_t pilot_iterations = std::min(choice->pilot_iterations, iterations);
  double sum = pilot_iterations * pilot_bias;
  if (choice->chosen) {
    const double bias = std::sqrt(choice->forecasts[*choice->chosen].squared_bias_bound);
    const double disks =
        iterations * mean_disk(alpha, iterations) - pilot_iterations * mean_disk(alpha, pilot_iterations);
    sum += bias * disks / mean_disk(alpha, choice->expected_iterations);
  } else if (counts.has(Technique::merge)) {
    return std::nullopt;  // the pilot saw nothing
  }
  return sum / iterations;
}

}  // namespace gmis
