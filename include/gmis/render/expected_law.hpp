#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/result/error_law.hpp"
#include "gmis/transport/allocation/choice.hpp"
#include "gmis/transport/state/settings.hpp"

namespace gmis {

/// The share of the forecast variance of `forecasts[chosen]` that is inversely proportional to the
/// area of the merging disk: from the forecast with the nearest factor on the radius, all other
/// counts equal. 0 where there is none to compare with.
[[nodiscard]] inline double merging_share(const std::vector<Forecast>& forecasts, std::size_t chosen) {
  const Forecast& one = forecasts[chosen];
  if (!one.counts.merges || !(one.variance > 0.0)) return 0.0;
  const Forecast* nearest = nullptr;
  const auto distance = [&](const Forecast& other) {
    return std::abs(std::log(other.counts.radius_factor / one.counts.radius_factor));
  };
  for (const Forecast& other : forecasts) {
    SampleCounts same = other.counts;
    same.radius_factor = one.counts.radius_factor;
    if (!(same == one.counts) || other.counts.radius_factor == one.counts.radius_factor) continue;
    if (nearest == nullptr || distance(other) < distance(*nearest)) nearest = &other;
  }
  if (nearest == nullptr) return 0.0;
  // V = V₀ + V₁ / disk.
  const double disk = disk_factor(nearest->counts, one.counts);
  return std::clamp((nearest->variance / one.variance - 1.0) / (1.0 / disk - 1.0), 0.0, 1.0);
}

/// e of `ErrorLaw` with `Sampler::sobol`, chosen with logs of the fourteen scenes of
/// `./run bench prices` and seeds 101 to 103. It is about 0.1 where light is hard to find, 0.4 in
/// most rooms, and above 0.8 under a sky.
inline constexpr double usual_evenness = 0.3;

/// The law by which the noise of a run is expected to fall, from what is known before the run. With
/// a choice it is the law of the chosen forecast: that of an iteration with the mean disk of the
/// run, for the radius of `counts`, the counts of the latest iteration. Without a choice only α,
/// below 1 where something merges, and the usual evenness of `settings.sampler` are known.
[[nodiscard]] inline ErrorLaw expected_law(const std::optional<Choice>& choice, const SampleCounts& counts,
                                           const RenderSettings& settings) {
  const double alpha = settings.alpha, exponent = counts.has(Technique::merge) ? alpha : 1.0;
  const double evenness = settings.sampler == Sampler::sobol ? usual_evenness : 0.0;
  if (!choice || !choice->chosen) return {0.0, 0.0, exponent, evenness};
  const double variance = choice->forecasts[*choice->chosen].variance;
  const double share = merging_share(choice->forecasts, *choice->chosen);
  const double narrowed = square(choice->forecasts[*choice->chosen].counts.radius_factor / counts.radius_factor);
  return {variance * (1.0 - share), variance * share * mean_disk(alpha, choice->expected_iterations) * narrowed,
          exponent, evenness};
}

}  // namespace gmis
