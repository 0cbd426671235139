#pragma once

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "transport/synthetic_path.hpp"

/// \file
/// Invented paths of the hardest kind, and their weights in 200 bits with an unbounded exponent.

namespace hostile {

using Wide = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<200, boost::multiprecision::digit_base_2, void, std::int64_t>>;
using Counts = gmis::TechniqueCounts<float>;
using Path = gmis_test::SyntheticPath<float>;

enum class Deltas { none, random, alternating, all };
constexpr std::array<const char*, 4> delta_names{"no delta vertices", "random delta vertices", "alternating with delta",
                                                 "delta vertices alone"};

/// Densities per area log-uniform in 1e±20, made of cosines in [1e-8, 1], squared distances in 1e±4
/// and what is left. `between(low, high)` draws a number.
template <class Between>
Path hard_path(Between&& between, int edges, Deltas deltas) {
  const auto area = [&] { return between(-20.0, 20.0); };
  const auto cosine = [&] { return between(-8.0, 0.0); };
  const auto unit = [&] { return between(0.0, 1.0); };
  const auto power = [](double exponent) { return static_cast<float>(std::pow(10.0, exponent)); };
  const auto n = static_cast<std::size_t>(edges) + 1;
  Path path;
  path.forward.resize(n);
  path.reverse.resize(n);
  path.to_area_from_light.resize(n);
  path.to_area_from_camera.resize(n);
  path.is_delta.resize(n);
  path.makes_photons.resize(n, true);
  if (unit() < 0.5) {  // a local count of merging
    path.makes_photons[0] = false;
    for (std::size_t i = 1; i < n; ++i) path.makes_photons[i] = unit() < 0.5;
  }
  std::vector<double> squared(n);  // of edge i → i + 1
  for (double& d : squared) d = between(-4.0, 4.0);
  for (std::size_t i = 0; i < n; ++i) {
    path.to_area_from_light[i] = power(cosine() - squared[i > 0 ? i - 1 : 0]);
    path.to_area_from_camera[i] = power(cosine() - squared[i]);
    const bool is_inside = i > 0 && i + 1 < n;
    path.is_delta[i] = is_inside && (deltas == Deltas::all || (deltas == Deltas::alternating && i % 2 == 0) ||
                                     (deltas == Deltas::random && unit() < 0.5));
  }
  for (std::size_t i = 0; i < n; ++i) {
    // Towards x_{i+1} and back to x_{i-1}: the density per steradian that makes the one per area.
    path.forward[i] = power(area() - std::log10(static_cast<double>(path.to_area_from_light[std::min(i + 1, n - 1)])));
    path.reverse[i] = power(area() - std::log10(static_cast<double>(path.to_area_from_camera[i > 0 ? i - 1 : 0])));
  }
  path.origin = power(area());
  path.first = power(area() - std::log10(static_cast<double>(path.to_area_from_light[1])));
  path.camera = power(area() - std::log10(static_cast<double>(path.to_area_from_camera[n - 2])));
  path.next_event = unit() < 0.3 ? path.origin : power(area());
  path.light_can_be_hit = unit() < 0.7 || deltas == Deltas::all;
  return path;
}

/// η from 1e-24 to 1e12, up to 1e6 light trees.
template <class Between>
Counts hard_counts(Between&& between) {
  return {1.0F, 1.0F, 1.0F, static_cast<float>(std::pow(10.0, between(0.0, 6.0))),
          static_cast<float>(std::pow(10.0, between(-24.0, 12.0)))};
}

/// The densities of all techniques, as `technique_densities` has them but with running products
/// from both ends.
inline std::vector<gmis::TechniqueDensity<Wide>> densities_of(const gmis::PathDensities<Wide>& path,
                                                              const Counts& counts) {
  const std::size_t k = path.from_light.size();
  std::vector<Wide> light(k + 1, Wide(1)), camera(k + 1, Wide(1));
  for (std::size_t i = 0; i < k; ++i) light[i + 1] = light[i] * path.from_light[i];
  for (std::size_t i = k; i-- > 0;) camera[i] = camera[i + 1] * path.from_camera[i];
  const auto joins = [&](std::size_t i) { return i == 0 || i == k || !path.is_delta[i]; };

  std::vector<gmis::TechniqueDensity<Wide>> all;
  for (std::size_t s = 0; s <= k; ++s) {
    Wide density(0);
    if (s == 0 && path.light_can_be_hit) density = Wide(counts.emitter_hit) * camera[0];
    if (s == 1 && joins(1)) density = Wide(counts.next_event) * path.next_event * camera[1];
    if (s >= 2 && s == k && joins(k - 1)) density = Wide(counts.splat) * light[k];
    if (s >= 2 && s < k && joins(s - 1) && joins(s)) density = Wide(counts.connect) * light[s] * camera[s];
    all.push_back({{false, static_cast<int>(s)}, density});
  }
  for (std::size_t i = 1; i < k; ++i) {
    const bool merges = joins(i) && path.makes_photons[i - 1];
    all.push_back(
        {{true, static_cast<int>(i)}, merges ? Wide(Wide(counts.merge) * light[i + 1] * camera[i]) : Wide(0)});
  }
  return all;
}

struct Tally {
  std::uint64_t paths = 0;
  std::uint64_t weights = 0;
  std::uint64_t out_of_range = 0;  ///< not a number, or not in [0, 1]
  double worst_weight = 0.0;       ///< relative error, of weights above 1e-30; absolute of others
  double worst_sum = 0.0;
};

template <class Heuristic>
void check_path(const Path& path, const Counts& counts, Tally& tally) {
  const gmis_test::RecursiveWeights<float, Heuristic> recursion(path, counts);
  auto densities = densities_of(gmis_test::path_densities<Wide>(path), counts);
  Wide total = 0;
  for (auto& technique : densities) total += technique.density = Heuristic::of(technique.density);
  if (total == 0) return;  // nothing can make this path
  ++tally.paths;
  double sum = 0.0;
  for (const auto& technique : densities) {
    if (technique.density == 0) continue;
    const float weight = recursion.weight(technique.technique);
    ++tally.weights;
    if (!(weight >= 0.0F && weight <= 1.0F)) {
      ++tally.out_of_range;
      continue;
    }
    sum += static_cast<double>(weight);
    const auto expected = static_cast<double>(Wide(technique.density / total));
    const double error = std::abs(static_cast<double>(weight) - expected);
    tally.worst_weight = std::max(tally.worst_weight, expected > 1e-30 ? error / expected : error);
  }
  tally.worst_sum = std::max(tally.worst_sum, std::abs(sum - 1.0));
}

}  // namespace hostile
