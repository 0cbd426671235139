#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "gmis/transport/operation_costs.hpp"
#include "gmis/transport/technique_groups.hpp"

namespace gmis {

/// Counts that a rendering could be made with.
struct Candidate {
  double light_paths = 1.0;  ///< light trees per pixel; 0: nothing is traced from the lights
  int connections = 1;       ///< light vertices per camera vertex; 0: none
  bool splats = true;
  bool merges = true;

  [[nodiscard]] constexpr bool traces_light() const noexcept { return light_paths > 0.0; }
  [[nodiscard]] constexpr bool operator==(const Candidate&) const = default;
};

/// What may be chosen from; the candidates are all combinations.
struct CandidateCounts {
  std::vector<double> light_paths{0.0, 0.25, 0.5, 1.0, 2.0};
  std::vector<int> connections{0, 1, 2, 4};
  std::vector<bool> merges{false, true};
  bool splats = true;  ///< whether light vertices are connected with the camera where light is traced at all
};

[[nodiscard]] inline std::vector<Candidate> all_candidates(const CandidateCounts& counts) {
  std::vector<Candidate> all;
  for (const double light_paths : counts.light_paths) {
    if (light_paths <= 0.0) {
      all.push_back({0.0, 0, false, false});
      continue;
    }
    for (const int connections : counts.connections)
      for (const bool merges : counts.merges)
        if (counts.splats || connections > 0 || merges)
          all.push_back({light_paths, connections, counts.splats, merges});
  }
  return all;
}

/// By how much each group's counts differ from those of a rendering with `made`, whose counts are not 0.
template <std::floating_point T>
[[nodiscard]] constexpr PerGroup<T> count_factors(const Candidate& candidate, const Candidate& made) noexcept {
  const double light = candidate.light_paths / made.light_paths;
  PerGroup<T> factors{};
  factors[static_cast<std::size_t>(TechniqueGroup::camera)] = T(1);
  if (!candidate.traces_light()) return factors;
  // Connections draw from whatever light vertices there are: their count is that of the draws.
  factors[static_cast<std::size_t>(TechniqueGroup::connect)] =
      static_cast<T>(static_cast<double>(candidate.connections) / static_cast<double>(made.connections));
  factors[static_cast<std::size_t>(TechniqueGroup::splat)] = candidate.splats ? static_cast<T>(light) : T(0);
  factors[static_cast<std::size_t>(TechniqueGroup::merge)] = candidate.merges ? static_cast<T>(light) : T(0);
  return factors;
}

/// What was done on the light side and on the camera side.
struct WorkBySide {
  Counters light, camera;
};

/// What an iteration with `candidate` takes, from the work of one with `made` (in units of `OperationCosts`).
[[nodiscard]] inline double predicted_cost(const Candidate& candidate, const Candidate& made, const WorkBySide& work,
                                           const OperationCosts& costs = {}) noexcept {
  const Counters& camera = work.camera;
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  double cost = times(costs.ray, camera.rays) + times(costs.shadow_ray, camera.shadow_rays - camera.connection_rays);
  if (!candidate.traces_light()) return cost;
  const double light = candidate.light_paths / made.light_paths;
  const double connections = static_cast<double>(candidate.connections) / static_cast<double>(made.connections);
  cost += light * times(costs.ray, work.light.rays);
  if (candidate.splats) cost += light * times(costs.shadow_ray, work.light.shadow_rays);
  if (candidate.connections > 0 || candidate.merges)
    cost += light * times(costs.photon_stored, work.light.photons_stored);
  cost += connections * (times(costs.connection, camera.connections) + times(costs.shadow_ray, camera.connection_rays));
  if (candidate.merges)
    cost += times(costs.merge_query, camera.merge_queries) + light * times(costs.merge, camera.merges);
  return cost;
}

/// What a pilot expects of a candidate.
struct Forecast {
  Candidate candidate;
  double variance = 0.0;       ///< of one iteration, relative to the squared values
  double squared_bias = 0.0;   ///< of merging, likewise
  double cost = 0.0;           ///< of one iteration, as `predicted_cost`
  double missing_share = 0.0;  ///< of the light: what none of its techniques can make

  /// Mean squared error times cost after that many iterations: what is to be small.
  [[nodiscard]] double work(double iterations) const noexcept { return (variance + iterations * squared_bias) * cost; }
};

/// Light that a candidate may miss, of all that a pilot saw: rounding, no more.
inline constexpr double negligible_share = 1e-6;

/// The place of the candidate with the least work of those that miss nothing; of none, when all miss something, the first
/// of those that miss least.
[[nodiscard]] inline std::size_t best_of(const std::vector<Forecast>& forecasts, double iterations) {
  const auto misses = [](const Forecast& f) { return f.missing_share > negligible_share; };
  std::size_t best = 0;
  for (std::size_t i = 1; i < forecasts.size(); ++i) {
    const Forecast &a = forecasts[i], &b = forecasts[best];
    if (misses(a) && misses(b)   ? a.missing_share < b.missing_share
        : misses(a) != misses(b) ? misses(b)
                                 : a.work(iterations) < b.work(iterations))
      best = i;
  }
  return best;
}

}  // namespace gmis
