#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gmis/result/counters.hpp"
#include "gmis/transport/state/operation_costs.hpp"
#include "gmis/transport/state/path_class.hpp"
#include "gmis/transport/state/technique.hpp"

/// \file
/// The cost of each path class. One subpath may serve paths of several classes, so the division is
/// a convention and not a measurement: work is divided in proportion to the contributions that use
/// it. To learn what a run saves without a class, render without it.

namespace gmis {

/// Number of contributions of one class and of the edges that they use.
struct ClassWork {
  std::array<std::uint64_t, technique_count> contributions{};  ///< by `Technique`
  std::uint64_t camera_edges = 0;                              ///< edges of camera subpaths, summed over contributions
  std::uint64_t light_edges = 0;                               ///< edges of light subpaths, summed over contributions

  /// Counts one contribution with t − 1 camera edges and s − 1 light edges (none for s = 0).
  constexpr void add(const TechniqueId& id) noexcept {
    ++contributions[static_cast<std::size_t>(id.technique)];
    camera_edges += static_cast<std::uint64_t>(id.t - 1);
    if (id.s > 0) light_edges += static_cast<std::uint64_t>(id.s - 1);
  }
  /// Adds the contributions of another run.
  constexpr ClassWork& operator+=(const ClassWork& other) noexcept {
    for (std::size_t i = 0; i < technique_count; ++i) contributions[i] += other.contributions[i];
    camera_edges += other.camera_edges;
    light_edges += other.light_edges;
    return *this;
  }
  /// Contributions of one technique.
  [[nodiscard]] constexpr std::uint64_t of(Technique technique) const noexcept {
    return contributions[static_cast<std::size_t>(technique)];
  }
  /// Contributions of all techniques.
  [[nodiscard]] constexpr std::uint64_t total() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : contributions) sum += count;
    return sum;
  }
};

/// Costs in the unit of `OperationCosts`.
struct ClassCosts {
  std::array<double, path_class_count> classes{};  ///< of each class
  double unattributed = 0.0;                       ///< cost of work that led to no contribution
};

/// Divides the cost of `work` among the classes. `light_work` is the part of `work` that light
/// trees took. The costs of all classes and `unattributed` sum to `cost_of(work)`. The cost of
/// - camera rays is divided in proportion to `camera_edges`, the cost of light rays in proportion
///   to `light_edges`;
/// - visibility queries, projections, connections and merges in proportion to the contributions of
///   the technique;
/// - stored photons in proportion to the contributions of connections and merges together.
[[nodiscard]] constexpr ClassCosts costs_of_classes(const std::array<ClassWork, path_class_count>& classes,
                                                    const Counters& work, const Counters& light_work,
                                                    const OperationCosts& costs = {}) noexcept {
  ClassCosts result;
  const auto share_out = [&](double cost, auto&& part_of) {
    double whole = 0.0;
    for (const ClassWork& one : classes) whole += static_cast<double>(part_of(one));
    if (whole == 0.0) {
      result.unattributed += cost;
      return;
    }
    for (std::size_t i = 0; i < path_class_count; ++i)
      result.classes[i] += cost * static_cast<double>(part_of(classes[i])) / whole;
  };
  const auto by = [](Technique technique) { return [technique](const ClassWork& one) { return one.of(technique); }; };
  const auto times = [](double cost, std::uint64_t count) { return cost * static_cast<double>(count); };
  const std::uint64_t next_event_rays = work.shadow_rays - light_work.shadow_rays - work.connection_rays;
  share_out(times(costs.ray, work.rays - light_work.rays), [](const ClassWork& one) { return one.camera_edges; });
  share_out(times(costs.ray, light_work.rays), [](const ClassWork& one) { return one.light_edges; });
  share_out(times(costs.shadow_ray, next_event_rays), by(Technique::next_event));
  share_out(times(costs.projection, work.projections) + times(costs.shadow_ray, light_work.shadow_rays),
            by(Technique::splat));
  share_out(times(costs.connection, work.connections) + times(costs.shadow_ray, work.connection_rays),
            by(Technique::connect));
  share_out(times(costs.merge_query, work.merge_queries) + times(costs.merge, work.merges), by(Technique::merge));
  share_out(times(costs.photon_stored, work.photons_stored),
            [](const ClassWork& one) { return one.of(Technique::connect) + one.of(Technique::merge); });
  return result;
}

}  // namespace gmis
