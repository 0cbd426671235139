#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/transport/state/operation_costs.hpp"
#include "gmis/transport/state/sample_counts.hpp"
#include "gmis/transport/weights/weights_by_technique.hpp"

namespace gmis {

/// The values to choose from for each count. The candidates are all combinations.
struct CountChoices {
  std::vector<double> light_paths{0.0, 0.125, 0.25, 0.5, 1.0};  ///< light trees per pixel
  std::vector<int> connections{0, 1, 2};                        ///< per camera vertex
  std::vector<bool> merges{false, true};                        ///< without and with merging
  std::vector<double> radius_factors{};  ///< empty: the factor in the first argument of `all_candidates`
};

/// Factors on the merging radius to choose from with a local count of merging
/// (`SampleCounts::local_merges`): few photons are merged, and the best disk is many times that of
/// plain merging, which stays a candidate. The work is flat around its least value, so that few
/// factors do. A run that needs a smaller disk than its first one finds it later
/// (render/merging_disk.hpp).
inline const std::vector<double> local_radius_factors{1.0, 6.0, 12.0};

/// The candidates: `all` with each combination of the values in `choices`. A technique that is off
/// in `all` is off in every candidate. Combinations with equal effect occur once.
GMIS_RARE [[nodiscard]] inline std::vector<SampleCounts> all_candidates(const SampleCounts& all = {},
                                                                        const CountChoices& choices = {}) {
  std::vector<SampleCounts> candidates;
  const auto add = [&](const SampleCounts& counts) {
    if (std::find(candidates.begin(), candidates.end(), counts) == candidates.end()) candidates.push_back(counts);
  };
  for (const double light_paths : choices.light_paths)
    for (const int connections : choices.connections)
      for (const bool merges : choices.merges) {
        SampleCounts counts = all;
        counts.light_paths = light_paths;
        if (all.connections != 0) counts.connections = connections;
        counts.merges = all.merges && merges;
        if (!counts.traces_light())
          counts.light_paths = 0.0, counts.connections = 0, counts.splats = counts.merges = false;
        if (!counts.merges) counts.local_merges = false, counts.radius_factor = 1.0;
        if (!counts.merges || choices.radius_factors.empty()) {
          add(counts);
          continue;
        }
        for (const double factor : choices.radius_factors) {
          counts.radius_factor = factor;
          add(counts);
        }
      }
  return candidates;
}

/// Mean over the iterations of a run of the merging disk's area relative to the first one:
/// r_i²/r_1² = i^(α−1). 1 for a run without iterations.
[[nodiscard]] inline double mean_disk(double alpha, std::uint32_t iterations) {
  constexpr std::uint32_t summed = 64;
  double sum = 0.0;
  for (std::uint32_t i = 1; i <= std::min(summed, iterations); ++i)
    sum += std::pow(static_cast<double>(i), alpha - 1.0);
  if (iterations > summed)  // the rest of the sum by the midpoint rule: ∫ x^(α−1) dx from summed + ½ to iterations + ½
    sum += (std::pow(iterations + 0.5, alpha) - std::pow(summed + 0.5, alpha)) / alpha;
  return iterations > 0 ? sum / static_cast<double>(iterations) : 1.0;
}

/// Area of the merging disk under `candidate` over that under `made`; 0 when the candidate does not
/// merge.
[[nodiscard]] inline double disk_factor(const SampleCounts& candidate, const SampleCounts& made) noexcept {
  const double ratio = candidate.radius_factor / made.radius_factor;
  return candidate.merges ? ratio * ratio : 0.0;
}

/// For each technique, its count under `candidate` divided by its count under `made`. All counts of
/// `made` must be above 0.
template <std::floating_point T>
[[nodiscard]] inline PerTechnique<T> count_factors(const SampleCounts& candidate, const SampleCounts& made) noexcept {
  const double light = candidate.light_paths / made.light_paths;
  PerTechnique<T> factors{};
  const auto factor_of = [&](Technique technique) -> T& { return factors[static_cast<std::size_t>(technique)]; };
  factor_of(Technique::emitter_hit) = factor_of(Technique::next_event) = T(1);
  if (!candidate.traces_light()) return factors;
  // ρ = m n_L / V̄ depends on the number m of draws alone, because V̄ is proportional to n_L.
  factor_of(Technique::connect) =
      static_cast<T>(static_cast<double>(candidate.connections) / static_cast<double>(made.connections));
  factor_of(Technique::splat) = candidate.splats ? static_cast<T>(light) : T(0);
  factor_of(Technique::merge) = static_cast<T>(light * disk_factor(candidate, made));
  return factors;
}

/// Predicted cost of the light trees under `candidate`, from their counted `work` under `made`;
/// `photons`: number of the stored vertices that merging gathers. Unit: `OperationCosts`.
[[nodiscard]] inline double predicted_light_cost(const SampleCounts& candidate, const SampleCounts& made,
                                                 const Counters& work, std::uint64_t photons,
                                                 const OperationCosts& costs = {}) noexcept {
  if (!candidate.traces_light()) return 0.0;
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  double cost = times(costs.ray, work.rays);
  if (candidate.splats) cost += times(costs.projection, work.projections) + times(costs.shadow_ray, work.shadow_rays);
  if (candidate.connections > 0)
    cost += times(costs.photon_stored, work.photons_stored);
  else if (candidate.merges)
    cost += times(costs.photon_stored, photons);
  return candidate.light_paths / made.light_paths * cost;
}

/// Predicted cost of the camera subpaths under `candidate`, from their counted `work` under `made`.
/// Unit: `OperationCosts`.
[[nodiscard]] inline double predicted_camera_cost(const SampleCounts& candidate, const SampleCounts& made,
                                                  const Counters& work, const OperationCosts& costs = {}) noexcept {
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  double cost = times(costs.ray, work.rays) + times(costs.shadow_ray, work.shadow_rays - work.connection_rays);
  if (!candidate.traces_light()) return cost;
  const double light = candidate.light_paths / made.light_paths;
  const double connections = static_cast<double>(candidate.connections) / static_cast<double>(made.connections);
  cost += connections * (times(costs.connection, work.connections) + times(costs.shadow_ray, work.connection_rays));
  if (candidate.merges)
    cost += times(costs.merge_query, work.merge_queries) +
            light * disk_factor(candidate, made) * times(costs.merge, work.merges);
  return cost;
}

/// Predicted error and cost of a run with `counts`.
struct Forecast {
  SampleCounts counts;         ///< what is forecast
  double variance = 0.0;       ///< of one iteration; mean over pixels of variance / (value² + 0.01), as in relMSE
  double squared_bias = 0.0;   ///< of merging over the whole run; relative in the same way
  double cost = 0.0;           ///< of one iteration; unit: `OperationCosts`
  double missing_share = 0.0;  ///< share of the light that no technique of the candidate can make

  /// Objective: mean squared error × cost of a run of `iterations`, (variance / N + bias²) · N ·
  /// cost.
  [[nodiscard]] double work(double iterations) const noexcept { return (variance + iterations * squared_bias) * cost; }
};

/// Smallest relative gain in `work` for which a candidate without merging is chosen over one that
/// merges. A plan has merging only where other techniques rarely find some paths. A pilot seldom
/// sees these paths, so its forecasts without merging are too optimistic.
inline constexpr double least_gain_of_not_merging = 0.13;

/// Smallest further gain for which a candidate is chosen that traces light trees for splats alone,
/// without connections and without merging. Some paths are then left to next events alone, and are
/// rare and bright where lights are near or hidden; the forecasts of such candidates were too
/// optimistic by a third where all others were within a tenth.
inline constexpr double least_gain_of_splats_alone = 0.25;

/// Share of the light that a candidate may miss and still count as complete; it covers rounding
/// only.
inline constexpr double negligible_share = 1e-6;

/// Index of the forecast with the least work among those that miss no light. When all of them miss
/// light, the index of the first one with the smallest missing share. `forecasts` must not be
/// empty.
[[nodiscard]] inline std::size_t best_of(const std::vector<Forecast>& forecasts, double iterations) {
  const auto has_splats_alone = [](const SampleCounts& counts) {
    return counts.traces_light() && counts.connections == 0 && !counts.merges;
  };
  const auto misses = [](const Forecast& f) { return f.missing_share > negligible_share; };
  const auto work_of = [&](const Forecast& f) {
    return f.work(iterations) / (f.counts.merges ? 1.0 : 1.0 - least_gain_of_not_merging) /
           (has_splats_alone(f.counts) ? 1.0 - least_gain_of_splats_alone : 1.0);
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
