#pragma once

#include <vector>

#include "gmis/transport/techniques/technique.hpp"

/// \file
/// The weights of a whole path by brute force: the density of every technique that can make it, as a product over all
/// vertices. It is what the recursion of weight_recursion.hpp must equal, and serves to debug a renderer of one's own.
/// Meant for `T` = long double (up to about 12 vertices of hard densities) or a type with an unbounded exponent.

namespace gmis {

/// The densities of one path x_0 … x_k (index 0 is on the light, k on the camera).
template <class T>
struct PathDensities {
  std::vector<T> from_light;   ///< a_i, i < k; a_0 with the probability of choosing the light
  std::vector<T> from_camera;  ///< b_i, i < k; of a delta event: selection probability and the geometry of the edge
  std::vector<bool> is_delta;  ///< the path goes through x_i by a delta event (0 < i < k)
  T next_event{};              ///< e_0: x_0 by next event, with the probability of choosing the light
  bool light_can_be_hit = true;
};

/// One way of making a path: `connect` with `s` light vertices (0: emitter hit, 1: next event, k: splat), or merging at
/// x_s.
struct TechniqueIndex {
  bool is_merge = false;
  int s = 0;
};

template <class T>
struct TechniqueDensity {
  TechniqueIndex technique;
  T density{};
};

/// The expected sample density of every technique, those that cannot make the path included with 0: s = 0 … k, then the
/// merges at x_1 … x_{k−1}.
template <class T, class Counts>
[[nodiscard]] std::vector<TechniqueDensity<T>> technique_densities(const PathDensities<T>& path, const Counts& counts) {
  const int k = static_cast<int>(path.from_light.size());
  const auto connectible = [&](int i) { return i == 0 || i == k || !path.is_delta[static_cast<std::size_t>(i)]; };
  const auto product = [&](int light_vertices, int camera_from) {
    T result(1);
    for (int i = 0; i < light_vertices; ++i) result *= path.from_light[static_cast<std::size_t>(i)];
    for (int i = camera_from; i < k; ++i) result *= path.from_camera[static_cast<std::size_t>(i)];
    return result;
  };

  std::vector<TechniqueDensity<T>> all;
  for (int s = 0; s <= k; ++s) {
    T density(0);
    if (s == 0) {
      if (path.light_can_be_hit) density = T(counts.emitter_hit) * product(0, 0);
    } else if (s == 1 && k >= 2) {
      if (connectible(1)) density = T(counts.next_event) * path.next_event * product(0, 1);
    } else if (s >= 2 && s == k) {
      if (connectible(k - 1)) density = T(counts.splat) * product(k, k);
    } else if (s >= 2) {
      if (connectible(s - 1) && connectible(s)) density = T(counts.connect) * product(s, s);
    }
    all.push_back({{false, s}, density});
  }
  for (int i = 1; i < k; ++i) {
    const bool can_merge = !path.is_delta[static_cast<std::size_t>(i)];
    all.push_back({{true, i}, can_merge ? T(counts.merge) * product(i + 1, i) : T(0)});
  }
  return all;
}

}  // namespace gmis
