#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/transport/choose/operation_costs.hpp"
#include "gmis/transport/sample_counts.hpp"
#include "gmis/transport/weights/weights_by_technique.hpp"

namespace gmis {

/// The values of each count to choose from; the candidates are all combinations.
struct CountChoices {
  std::vector<double> light_paths{0.0, 0.25, 0.5, 1.0, 2.0};
  std::vector<int> connections{0, 1, 2, 4};
  std::vector<bool> merges{false, true};
  std::vector<int> camera_children{1, 2, 4};
};

/// `all` with each combination of these values. A technique that is off in `all` is off in every candidate; counts that
/// come to the same occur once.
[[nodiscard]] inline std::vector<SampleCounts> all_candidates(const SampleCounts& all = {},
                                                              const CountChoices& choices = {}) {
  std::vector<SampleCounts> candidates;
  for (const int children : choices.camera_children)
    for (const double light_paths : choices.light_paths)
      for (const int connections : choices.connections)
        for (const bool merges : choices.merges) {
          SampleCounts counts = all;
          counts.camera_children = children;
          counts.light_paths = light_paths;
          if (all.connections != 0) counts.connections = connections;
          counts.merges = all.merges && merges;
          if (!counts.traces_light())
            counts.light_paths = 0.0, counts.connections = 0, counts.splats = counts.merges = false;
          if (std::find(candidates.begin(), candidates.end(), counts) == candidates.end()) candidates.push_back(counts);
        }
  return candidates;
}

/// The mean over a run's iterations of r_i²/r_1², the disk that is merged in: r_i² = r_1² i^(α−1).
[[nodiscard]] inline double mean_disk(double alpha, std::uint32_t iterations) {
  constexpr std::uint32_t summed = 64;
  double sum = 0.0;
  for (std::uint32_t i = 1; i <= std::min(summed, iterations); ++i)
    sum += std::pow(static_cast<double>(i), alpha - 1.0);
  if (iterations > summed)  // the integral, from half a step behind the sum on
    sum += alpha > 0.0 ? (std::pow(iterations + 0.5, alpha) - std::pow(summed + 0.5, alpha)) / alpha
                       : std::log((iterations + 0.5) / (summed + 0.5));
  return iterations > 0 ? sum / static_cast<double>(iterations) : 1.0;
}

/// By how much each technique's count differs from those of a rendering with `made`, whose counts are not 0.
template <std::floating_point T>
[[nodiscard]] constexpr PerTechnique<T> count_factors(const SampleCounts& candidate,
                                                      const SampleCounts& made) noexcept {
  const double light = candidate.light_paths / made.light_paths;
  PerTechnique<T> factors{};
  const auto factor_of = [&](Technique technique) -> T& { return factors[static_cast<std::size_t>(technique)]; };
  factor_of(Technique::emitter_hit) = factor_of(Technique::next_event) = T(1);
  if (!candidate.traces_light()) return factors;
  // Connections draw from whatever light vertices there are: their count is that of the draws.
  factor_of(Technique::connect) =
      static_cast<T>(static_cast<double>(candidate.connections) / static_cast<double>(made.connections));
  factor_of(Technique::splat) = candidate.splats ? static_cast<T>(light) : T(0);
  factor_of(Technique::merge) = candidate.merges ? static_cast<T>(light) : T(0);
  return factors;
}

/// What was done for camera subpaths up to their first non-specular vertices and at these, and for the children of these.
struct CameraWork {
  Counters before, children;
  double mean_children = 1.0;  ///< that there were
};

/// What light trees take in an iteration with `candidate`, from what was done for them in one with `made` (in units of
/// `OperationCosts`).
[[nodiscard]] inline double predicted_light_cost(const SampleCounts& candidate, const SampleCounts& made,
                                                 const Counters& work, const OperationCosts& costs = {}) noexcept {
  if (!candidate.traces_light()) return 0.0;
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  double cost = times(costs.ray, work.rays);
  if (candidate.splats) cost += times(costs.shadow_ray, work.shadow_rays);
  if (candidate.connections > 0 || candidate.merges) cost += times(costs.photon_stored, work.photons_stored);
  return candidate.light_paths / made.light_paths * cost;
}

/// The same for its camera subpaths.
[[nodiscard]] inline double predicted_camera_cost(const SampleCounts& candidate, const SampleCounts& made,
                                                  const CameraWork& work, const OperationCosts& costs = {}) noexcept {
  const double light = candidate.light_paths / made.light_paths;
  const double connections = static_cast<double>(candidate.connections) / static_cast<double>(made.connections);
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  const auto cost_of_part = [&](const Counters& part) {
    double cost = times(costs.ray, part.rays) + times(costs.shadow_ray, part.shadow_rays - part.connection_rays);
    if (!candidate.traces_light()) return cost;
    cost += connections * (times(costs.connection, part.connections) + times(costs.shadow_ray, part.connection_rays));
    if (candidate.merges)
      cost += times(costs.merge_query, part.merge_queries) + light * times(costs.merge, part.merges);
    return cost;
  };
  const double more = static_cast<double>(candidate.camera_children - 1);
  return cost_of_part(work.before) +
         (1.0 + more * costs.further_child) * cost_of_part(work.children) / work.mean_children;
}

/// What a pilot expects of a run with certain counts.
struct Forecast {
  SampleCounts counts;
  double variance = 0.0;       ///< of one iteration, relative as relMSE is
  double squared_bias = 0.0;   ///< of merging, likewise, in the mean of the run
  double cost = 0.0;           ///< of one iteration, counted (in units of `OperationCosts`)
  double missing_share = 0.0;  ///< of the light: what none of its techniques can make

  /// Mean squared error times cost after that many iterations: what is to be small.
  [[nodiscard]] double work(double iterations) const noexcept { return (variance + iterations * squared_bias) * cost; }
};

/// What a candidate that splits must gain over those that do not: less is within what its forecast is off by.
inline constexpr double least_gain_of_splitting = 0.05;

/// What a candidate that leaves merging out must gain over those that merge. A plan has merging where some paths are hard
/// to find in any other way; how hard is seen by a pilot too seldom, so forecasts without merging are too good.
inline constexpr double least_gain_of_not_merging = 0.13;

/// Light that a candidate may miss, of all that a pilot saw: rounding, no more.
inline constexpr double negligible_share = 1e-6;

/// The place of the candidate with the least work of those that miss nothing; of none, when all miss something, the first
/// of those that miss least.
[[nodiscard]] inline std::size_t best_of(const std::vector<Forecast>& forecasts, double iterations) {
  const auto misses = [](const Forecast& f) { return f.missing_share > negligible_share; };
  const auto work_of = [&](const Forecast& f) {
    return f.work(iterations) / (f.counts.camera_children > 1 ? 1.0 - least_gain_of_splitting : 1.0) /
           (f.counts.merges ? 1.0 : 1.0 - least_gain_of_not_merging);
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < forecasts.size(); ++i) {
    const Forecast &a = forecasts[i], &b = forecasts[best];
    if (misses(a) && misses(b)   ? a.missing_share < b.missing_share
        : misses(a) != misses(b) ? misses(b)
                                 : work_of(a) < work_of(b))
      best = i;
  }
  return best;
}

}  // namespace gmis
