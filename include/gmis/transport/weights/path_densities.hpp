#pragma once

#include <vector>

#include "gmis/transport/state/technique.hpp"

/// \file
/// The weights of a whole path by brute force: the expected sample density of every technique that
/// can make the path, as a product over all vertices. It is the oracle for weight_recursion.hpp,
/// and it helps to debug a renderer. `T` is meant to be long double (up to about 12 vertices with
/// extreme densities) or a type with an unbounded exponent.

namespace gmis {

/// The densities of one path x_0 … x_k (index 0 is on the light, k on the camera).
template <class T>
struct PathDensities {
  std::vector<T> from_light;  ///< a_i per area, i < k; a_0 includes the probability of choosing the light
  std::vector<T>
      from_camera;  ///< b_i per area, i < k; after a delta event: selection probability × geometry of the edge
  std::vector<bool> is_delta;  ///< whether the path goes through x_i by a delta event (0 < i < k)
  /// s(x_i), i < k − 1: whether light vertices that were made from x_i are photons, which merging
  /// gathers. Empty: all.
  std::vector<bool> makes_photons = {};
  T next_event{};                ///< e_0: density of x_0 by next event; includes the probability of choosing the light
  bool light_can_be_hit = true;  ///< false for a delta light
};

/// One way to make a path: a connection with `s` light vertices (0: emitter hit, 1: next event, k:
/// splat), or merging at x_s.
struct TechniqueIndex {
  bool is_merge = false;  ///< merging at x_s, else a connection
  int s = 0;              ///< light vertices, or the number of the merged vertex
};

/// A technique and its expected sample density.
template <class T>
struct TechniqueDensity {
  TechniqueIndex technique;  ///< which it is
  T density{};               ///< expected number of samples times density, product over the path
};

/// The expected sample density κ_s U(s) of every technique, in the order s = 0 … k, then s(x_{i−1})
/// μ b_i U(i+1) of merging at x_1 … x_{k−1}. A technique that cannot make the path has the
/// density 0. U(s) = Π_{i<s} a_i Π_{i≥s} b_i.
template <class T, class Counts>
[[nodiscard]] std::vector<TechniqueDensity<T>> technique_densities(const PathDensities<T>& path, const Counts& counts) {
  const int k = static_cast<int>(path.from_light.size());
  const auto connectible = [&](int i) { return i == 0 || i == k || !path.is_delta[static_cast<std::size_t>(i)]; };
  // Π a_i over i < light_vertices, times Π b_i over i ≥ camera_from
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
      if (path.light_can_be_hit) density = T(counts.emitter_hit) * product(0, 0);  // κ_0 U(0)
    } else if (s == 1 && k >= 2) {
      if (connectible(1)) density = T(counts.next_event) * path.next_event * product(0, 1);  // e_0 U(1) / a_0
    } else if (s >= 2 && s == k) {
      if (connectible(k - 1)) density = T(counts.splat) * product(k, k);  // n_L U(k)
    } else if (s >= 2) {
      if (connectible(s - 1) && connectible(s)) density = T(counts.connect) * product(s, s);  // ρ U(s)
    }
    all.push_back({{false, s}, density});
  }
  for (int i = 1; i < k; ++i) {
    const bool is_photon = path.makes_photons.empty() || path.makes_photons[static_cast<std::size_t>(i) - 1];
    const bool can_merge = is_photon && !path.is_delta[static_cast<std::size_t>(i)];
    all.push_back({{true, i}, can_merge ? T(counts.merge) * product(i + 1, i) : T(0)});  // s μ b_i U(i+1)
  }
  return all;
}

}  // namespace gmis
