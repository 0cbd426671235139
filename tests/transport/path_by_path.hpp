#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/discrete_world.hpp"
#include "transport/guide_oracle.hpp"
#include "transport/path_oracle.hpp"
#include "transport/ways.hpp"

/// \file
/// The engine's own paths, each contribution against brute force: its weight against the densities
/// of all techniques that can make that path, its value against the light the path carries over the
/// density of the technique that made it. Nothing is estimated: an error of any size in a weight, a
/// density, a cosine, a Jacobian or a count shows in single contributions.

namespace gmis_test::path_by_path {

struct Outcome {
  double worst_weight = 0.0, worst_value = 0.0, worst_sum = 0.0;  ///< relative errors
  std::string worst_weight_at, worst_value_at;
  std::size_t contributions = 0, impossible = 0;
  std::array<std::size_t, 5> by_technique{};          ///< contributions of each
  std::array<std::size_t, 8> whole_paths_by_edges{};  ///< paths of which every technique was seen
  std::size_t whole_paths = 0;
};

[[nodiscard]] inline std::string describe(const gmis::TechniqueId& id, const DiscretePath& path) {
  std::ostringstream text;
  text << "technique " << static_cast<int>(id.technique) << " s " << id.s << " t " << id.t << " path";
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    text << ' ' << path.nodes[i];
    if (path.lobes[i] != Tag::smooth) text << 'd' << path.lobes[i];
  }
  return text.str();
}

[[nodiscard]] inline ways::Settings settings(std::uint64_t seed) {
  ways::Settings result;
  result.seed = seed;
  result.max_depth = 5;
  result.radius = 0.4;  // the nodes are farther apart: only vertices at the same node merge
  result.alpha = 1.0;
  result.counts.light_paths = 0.1;
  result.sampler.budget = 1000000;
  result.counts.connects_paired_tree = true;
  return result;
}

/// These settings with a tree a pixel, and connections drawn from the cache of all trees.
[[nodiscard]] inline ways::Settings with_cache(ways::Settings settings, int connections) {
  settings.counts.light_paths = 1.0;
  settings.counts.connections = connections;
  settings.counts.connects_paired_tree = false;
  return settings;
}

/// The densities, weights and value of one path by brute force, and the engine's weights.
struct Known {
  std::vector<long double> drawn_density;  ///< a connection's with one particular vertex of a tree
  std::vector<long double> weight;
  std::vector<double> seen;  ///< the engine's weight, −1 before a technique was seen
  long double value = 0.0L;
};

template <class Heuristic>
class KnownPaths {
 public:
  KnownPaths(const PathOracle& oracle, const gmis::TechniqueCounts<long double>& counts)
      : oracle_(oracle), counts_(counts) {}
  Known& operator[](const DiscretePath& path) {
    const auto found = known_.find(path);
    if (found != known_.end()) return found->second;
    const auto brute_force = oracle_(path);
    Known entry;
    entry.value = brute_force.value;
    long double total = 0.0L;
    for (const auto& technique : gmis::technique_densities(brute_force.densities, counts_)) {
      entry.weight.push_back(Heuristic::of(technique.density));
      total += entry.weight.back();
    }
    auto drawn_counts = counts_;
    if (drawn_counts.connect > 0.0L) drawn_counts.connect = 1.0L;
    for (const auto& technique : gmis::technique_densities(oracle_(path, true).densities, drawn_counts))
      entry.drawn_density.push_back(technique.density);
    // Light seen directly is the emitter hit's alone.
    for (long double& weight : entry.weight) weight = path.edges() == 1 ? 1.0L : weight / total;
    entry.seen.assign(entry.drawn_density.size(), -1.0);
    return known_.emplace(path, entry).first->second;
  }
  void sum_up(Outcome& outcome) const {
    for (const auto& [path, entry] : known_) {
      double sum = 0.0;
      bool is_whole = true;
      for (std::size_t i = 0; i < entry.drawn_density.size(); ++i)
        if (entry.drawn_density[i] > 0.0L) {
          is_whole = is_whole && entry.seen[i] >= 0.0;
          sum += entry.seen[i];
        }
      if (!is_whole) continue;
      ++outcome.whole_paths;
      ++outcome.whole_paths_by_edges[static_cast<std::size_t>(path.edges())];
      outcome.worst_sum = std::max(outcome.worst_sum, std::abs(sum - 1.0));
    }
  }

 private:
  const PathOracle& oracle_;
  gmis::TechniqueCounts<long double> counts_;
  std::map<DiscretePath, Known> known_;
};

template <class I>
NominalCounts nominal_counts(const ways::Settings& render_settings) {
  NominalCounts nominal;
  if (I::splits_light) nominal.light_per_lobe = render_settings.sampler.rounds;
  nominal.camera_stops = !I::extends_camera;
  nominal.local_merges = render_settings.counts.local_merges;
  return nominal;
}

/// `connect`: the count of connections, for one light vertex that a tree makes. The disk of merging
/// is that of the iteration, r_i = r_1 i^((α−1)/2).
template <class I>
gmis::TechniqueCounts<long double> technique_counts(const ways::Settings& render_settings, int iteration,
                                                    long double trees, long double connect) {
  const long double disk =
      gmis::pi<long double> *
      gmis::square(static_cast<long double>(*render_settings.radius * render_settings.counts.radius_factor)) *
      std::pow(static_cast<long double>(iteration), static_cast<long double>(render_settings.alpha) - 1.0L);
  gmis::TechniqueCounts<long double> counts;
  counts.emitter_hit = I::has(gmis::Technique::emitter_hit) ? 1.0L : 0.0L;
  counts.next_event = I::has(gmis::Technique::next_event) ? 1.0L : 0.0L;
  counts.connect = I::has(gmis::Technique::connect) ? connect : 0.0L;
  counts.splat = I::has(gmis::Technique::splat) ? trees : 0.0L;
  counts.merge = I::has(gmis::Technique::merge) ? trees * disk : 0.0L;
  return counts;
}

/// A relative error, and where it was the largest.
template <class Where>
void update(double& worst, std::string& worst_at, long double ratio, Where&& where) {
  const double error = static_cast<double>(std::abs(ratio - 1.0L));
  if (error <= worst) return;
  worst = std::isnan(error) ? 1e9 : error;
  worst_at = where();
}

/// The count of connections that a weight was made with, when the other counts are known: the
/// pilot's mean number of vertices of a tree is the engine's own business.
template <class I>
long double connect_count(const PathOracle& oracle, const DiscretePath& path, std::size_t place,
                          const gmis::TechniqueCounts<long double>& counts, long double weight) {
  auto unit = counts;
  unit.connect = 1.0L;
  long double connections = 0.0L, others = 0.0L, own = 0.0L;
  const auto all = gmis::technique_densities(oracle(path).densities, unit);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool connects = !all[i].technique.is_merge && all[i].technique.s >= 2 && all[i].technique.s < path.edges();
    (connects ? connections : others) += all[i].density;
    if (i == place) own = all[i].density;
  }
  return weight * others / (own - weight * connections);
}

template <class I, class World>
Outcome run(bool has_parallel_rays, const ways::Settings& render_settings, int iterations) {
  using T = gmis::ScalarOf<typename World::Spectrum>;
  const int size = 32;
  const World world(make_atlas<T>(5, has_parallel_rays), size);
  const auto atlas = world.atlas().template as<long double>();
  auto nominal = nominal_counts<I>(render_settings);
  nominal.chooses_for_receiver = gmis::SceneWithReceiverChoice<World>;
  const auto guide = random_guide(world, render_settings.seed);
  if (render_settings.emission == gmis::Emission::learned)
    nominal.emission_ratio = [&](std::size_t light, std::size_t surface) {
      return guide_ratio(guide, world, atlas, light, surface);
    };
  if constexpr (requires { World::tell(nominal, atlas); }) World::tell(nominal, atlas);
  const PathOracle oracle(atlas, nominal);
  const long double trees = std::round(render_settings.counts.light_paths * size * size);
  auto counts = technique_counts<I>(render_settings, 1, trees, 1.0L);

  typename I::template Engine<World> engine(world, I::settings(render_settings));
  engine.keep_contributions(true);
  if (render_settings.emission == gmis::Emission::learned) {
    const auto lights = std::make_shared<gmis::LearnedLights<World>>();
    lights->guide = guide;
    engine.use_lights(lights);
  }
  gmis::SerialExecutor executor;
  engine.iterate(executor);
  const bool uses_cache = I::has(gmis::Technique::connect) && !render_settings.counts.connects_paired_tree;
  if (uses_cache) {
    bool is_found = false;
    engine.for_each_contribution([&](const auto& record) {
      if (is_found || record.id.technique != gmis::Technique::connect) return;
      const DiscretePath path = path_of(record.value);
      counts.connect = connect_count<I>(oracle, path, place_of(record.id, path.edges()), counts, record.weight);
      is_found = true;
    });
    CHECK(static_cast<double>(counts.connect) * engine.vertices_per_tree() ==
          Approx(static_cast<double>(render_settings.counts.connections)).epsilon(1e-3));
    const double vertices_per_tree = static_cast<double>(engine.counters().photons_stored) / static_cast<double>(trees);
    CHECK(engine.vertices_per_tree() ==
          Approx(vertices_per_tree).epsilon(0.2));  // 1024 trees of 1 ± 1 vertices: 6 standard errors
  }
  std::optional<KnownPaths<typename I::Heuristic>> known;

  Outcome outcome;
  std::uint64_t stored_before = 0;
  for (int i = 0; i < iterations; ++i) {
    if (i > 0) engine.iterate(executor);
    // With a radius that shrinks, the weights of an iteration are its own.
    if (i == 0 || render_settings.alpha != 1.0) {
      if (known) known->sum_up(outcome);
      counts = technique_counts<I>(render_settings, i + 1, trees, counts.connect);
      known.emplace(oracle, counts);
    }
    const auto stored = static_cast<long double>(engine.counters().photons_stored - stored_before);
    stored_before = engine.counters().photons_stored;
    // What is drawn from the cache stands for V / (m n_L) vertices of one tree.
    const long double from_cache =
        uses_cache ? static_cast<long double>(render_settings.counts.connections) * trees / stored : 1.0L;
    engine.for_each_contribution([&](const auto& record) {
      const DiscretePath path = path_of(record.value);
      Known& entry = (*known)[path];
      const std::size_t place = place_of(record.id, path.edges());
      ++outcome.contributions;
      if (path.edges() != edges_of(record.id) || !(entry.drawn_density[place] > 0.0L)) {
        ++outcome.impossible;
        return;
      }
      ++outcome.by_technique[static_cast<std::size_t>(record.id.technique)];
      entry.seen[place] = static_cast<double>(record.weight);
      const long double drawn =
          entry.drawn_density[place] * (record.id.technique == gmis::Technique::connect ? from_cache : 1.0L);
      const auto where = [&] { return describe(record.id, path); };
      update(outcome.worst_weight, outcome.worst_weight_at,
             static_cast<long double>(record.weight) / entry.weight[place], where);
      update(outcome.worst_value, outcome.worst_value_at,
             static_cast<long double>(record.value.value) * drawn / entry.value, where);
    });
  }
  known->sum_up(outcome);
  CHECK(engine.counters().rejected() == 0);
  return outcome;
}

/// `whole`: at least this number of paths was seen by every one of their techniques, so that the
/// sum over them means something.
inline void check(const Outcome& outcome, double tolerance, std::size_t whole) {
  CAPTURE(outcome.worst_weight_at, outcome.worst_value_at, outcome.worst_weight / tolerance,
          outcome.worst_value / tolerance, outcome.worst_sum / tolerance);
  CAPTURE(outcome.contributions, outcome.whole_paths, outcome.whole_paths_by_edges, outcome.by_technique);
  CHECK(outcome.worst_weight < tolerance);
  CHECK(outcome.worst_value < tolerance);
  CHECK(outcome.worst_sum < tolerance);
  CHECK(outcome.impossible == 0);
  CHECK(outcome.whole_paths >= whole);
}

template <class I, class World>
void check_both_cameras(double tolerance, std::size_t whole, const ways::Settings& render_settings,
                        int iterations = 4) {
  for (const bool has_parallel_rays : {false, true}) {
    CAPTURE(has_parallel_rays);
    check(run<I, World>(has_parallel_rays, render_settings, iterations), tolerance, whole);
  }
}

}  // namespace gmis_test::path_by_path
