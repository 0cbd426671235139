#pragma once

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "gmis/transport/weights/path_densities.hpp"
#include "gmis/transport/weights/weight_recursion.hpp"

namespace gmis_test {

/// The elementary densities of an invented path, from which both the recursion and the brute-force
/// sum are fed. Index i is the vertex x_i; `T` is what the recursion computes in.
template <class T>
struct SyntheticPath {
  std::vector<T> forward;              ///< at x_i towards x_{i+1}, as a light subpath, per steradian, i ≥ 1
  std::vector<T> reverse;              ///< at x_i towards x_{i-1}, as a camera subpath, per steradian, i ≥ 1
  std::vector<T> to_area_from_light;   ///< at x_i for a ray from x_{i-1}, 1 ≤ i < k
  std::vector<T> to_area_from_camera;  ///< at x_i for a ray from x_{i+1}, 0 ≤ i < k
  std::vector<bool> is_delta;
  std::vector<bool> makes_photons;  ///< s(x_i)
  T origin{}, first{}, next_event{}, camera{};
  /// Probabilities of choosing the light: of light subpaths, and of next events at x_1, which may
  /// depend on x_1.
  T emission_choice{1}, next_event_choice{1};
  bool light_can_be_hit = true;

  [[nodiscard]] int edges() const { return static_cast<int>(is_delta.size()) - 1; }
};

/// Factors log-uniform in 10^±`decades`; every vertex between the ends is delta with probability
/// `delta_chance`. The count of merging is local with probability `local_chance`: then the light
/// makes no photons, and half of the surfaces do. With `chooses_for_receiver` next events choose
/// the light with another probability than light subpaths do.
template <class T>
SyntheticPath<T> random_path(std::mt19937_64& source, int edges, double decades, double delta_chance,
                             double local_chance = 0.0, bool chooses_for_receiver = false) {
  std::uniform_real_distribution<double> exponent(-decades, decades);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto factor = [&] { return static_cast<T>(std::pow(10.0, exponent(source))); };
  // Nominal numbers of children: 1 without splitting, otherwise any number of a few, less what
  // roulette ends.
  const auto children = [&] { return static_cast<T>(unit(source) < 0.5 ? 1.0 : 0.2 + 4.0 * unit(source)); };
  const auto count = static_cast<std::size_t>(edges) + 1;
  SyntheticPath<T> path;
  path.forward.resize(count);
  path.reverse.resize(count);
  path.to_area_from_light.resize(count);
  path.to_area_from_camera.resize(count);
  path.is_delta.resize(count);
  path.makes_photons.resize(count, true);
  const bool is_local = local_chance > 0.0 && unit(source) < local_chance;
  path.makes_photons[0] = !is_local;
  for (std::size_t i = 0; i < count; ++i) {
    path.is_delta[i] = i > 0 && i + 1 < count && unit(source) < delta_chance;
    if (is_local && i > 0) path.makes_photons[i] = unit(source) < 0.5;
    path.forward[i] = factor() * children();
    path.reverse[i] = factor() * children();
    path.to_area_from_light[i] = factor();
    path.to_area_from_camera[i] = factor();
  }
  path.origin = factor();
  path.first = factor();
  path.camera = factor();
  // An area light (both densities alike), a light sampled by direction, a light that only next
  // event and emission reach.
  const double kind = unit(source);
  path.next_event = kind < 0.3 ? path.origin : factor();
  path.light_can_be_hit = kind < 0.7;
  if (chooses_for_receiver) {
    const auto choice = [&] { return static_cast<T>(std::pow(10.0, -4.0 * unit(source))); };
    path.emission_choice = choice();
    path.next_event_choice = choice();
  }
  return path;
}

/// The same path as densities per area, in `Wide`.
template <class Wide, class T>
gmis::PathDensities<Wide> path_densities(const SyntheticPath<T>& path) {
  const auto k = static_cast<std::size_t>(path.edges());
  gmis::PathDensities<Wide> result;
  for (std::size_t i = 0; i < k; ++i) {
    const Wide a = i == 0 ? Wide(path.emission_choice) * Wide(path.origin)
                          : Wide(i == 1 ? path.first : path.forward[i - 1]) * Wide(path.to_area_from_light[i]);
    const Wide b = Wide(i + 1 == k ? path.camera : path.reverse[i + 1]) * Wide(path.to_area_from_camera[i]);
    result.from_light.push_back(a);
    result.from_camera.push_back(b);
  }
  result.is_delta = path.is_delta;
  result.makes_photons = path.makes_photons;
  result.next_event = Wide(path.next_event_choice) * Wide(path.next_event);
  result.light_can_be_hit = path.light_can_be_hit;
  return result;
}

/// Runs the recursion along the path from both ends, as a renderer would, and gives the weight of
/// any technique.
template <class T, class Heuristic, class Sums = gmis::WholeSum<T>>
class RecursiveWeights {
 public:
  RecursiveWeights(const SyntheticPath<T>& path, const gmis::TechniqueCounts<T>& counts)
      : path_(path), weights_(with_first(counts, path)), light_(path.is_delta.size()), camera_(path.is_delta.size()) {
    const auto k = static_cast<std::size_t>(path.edges());
    if (k >= 2) {
      light_[1] = weights_.first_light_vertex({origin(), next_event(), light_density(1)},
                                              path.light_can_be_hit ? path.to_area_from_camera[0] : T(0));
      for (std::size_t i = 1; i + 1 < k; ++i)
        light_[i + 1] = weights_.extend_light(light_[i], {is_photon(i), path.is_delta[i], path.reverse[i],
                                                          path.to_area_from_camera[i], light_density(i + 1)});
    }
    camera_[k - 1] = weights_.first_camera_vertex(camera_density(k - 1));
    for (std::size_t j = k - 1; j >= 1; --j)
      camera_[j - 1] =
          weights_.extend_camera(camera_[j], {j == k - 1, path.makes_photons[j - 1], path.is_delta[j], path.forward[j],
                                              path.to_area_from_light[j], camera_density(j - 1)});
  }

  [[nodiscard]] auto weight(const gmis::TechniqueIndex& technique) const {
    const auto k = static_cast<std::size_t>(path_.edges());
    const auto s = static_cast<std::size_t>(technique.s);
    if (technique.is_merge)
      return weights_.merge(light_[s], path_.reverse[s], camera_[s], {s == k - 1, path_.forward[s], T(0)});
    if (s == 0)
      return k == 1 ? weights_.seen_directly()
                    : weights_.emitter_hit(camera_[0], {origin(), next_event(), path_.first});
    if (s == 1)
      return weights_.next_event({origin(), next_event(), T(0)}, path_.light_can_be_hit ? camera_density(0) : T(0),
                                 camera_[1], {k == 2, path_.forward[1], light_density(1)});
    const gmis::LightEnd<T> light_end{is_photon(s - 1), path_.makes_photons[s - 1], path_.reverse[s - 1],
                                      camera_density(s - 1)};
    if (s == k) return weights_.splat(light_[k - 1], light_end);
    return weights_.connect(light_[s - 1], light_end, camera_[s], {s == k - 1, path_.forward[s], light_density(s)});
  }

 private:
  [[nodiscard]] static gmis::TechniqueCounts<T> with_first(gmis::TechniqueCounts<T> counts,
                                                           const SyntheticPath<T>& path) {
    counts.merges_first = path.makes_photons[0];
    return counts;
  }
  /// a_0 and e_0.
  [[nodiscard]] T origin() const { return path_.emission_choice * path_.origin; }
  [[nodiscard]] T next_event() const { return path_.next_event_choice * path_.next_event; }
  /// s(x_{i-1}).
  [[nodiscard]] bool is_photon(std::size_t i) const { return path_.makes_photons[i - 1]; }
  [[nodiscard]] T light_density(std::size_t i) const {
    return (i == 1 ? path_.first : path_.forward[i - 1]) * path_.to_area_from_light[i];
  }
  [[nodiscard]] T camera_density(std::size_t i) const {
    return (i + 1 == static_cast<std::size_t>(path_.edges()) ? path_.camera : path_.reverse[i + 1]) *
           path_.to_area_from_camera[i];
  }

  const SyntheticPath<T>& path_;
  using Recursion = gmis::WeightRecursion<T, Heuristic, Sums>;
  Recursion weights_;
  std::vector<typename Recursion::LightPartial> light_;
  std::vector<typename Recursion::CameraPartial> camera_;
};

}  // namespace gmis_test
