#pragma once

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "gmis/transport/emission/emission_guide.hpp"
#include "transport/discrete_world.hpp"

/// \file
/// A guide of emission for a discrete world, and what it says of one start, written down afresh in
/// long double.

namespace gmis_test {

/// A guide with random tables and rings for three of the four lights.
template <class World>
[[nodiscard]] gmis::EmissionGuide<World> random_guide(const World& world, std::uint64_t seed) {
  using T = gmis::ScalarOf<typename World::Spectrum>;
  using Guided = gmis::GuidedLight<T, typename World::Light>;
  std::mt19937_64 source(seed);
  std::uniform_real_distribution<double> unit(0.05, 1.0);
  std::vector<Guided> lights;
  const std::array<T, 3> probabilities{T(0.5), T(0.3), T(0.2)};
  for (const std::size_t number : {3U, 0U, 2U}) {
    std::array<double, gmis::SquareTable<T>::size> masses{};
    for (double& mass : masses) mass = unit(source) * unit(source);
    typename gmis::Aim<T>::Radii radii{};
    for (std::size_t k = 1; k < radii.size(); ++k) radii[k] = radii[k - 1] + T(0.2 * unit(source));
    const gmis::Vec3<T> centre(T(unit(source) - 0.5), T(unit(source) - 0.5), T(unit(source) - 0.5));
    lights.push_back({&world.lights()[number], probabilities[lights.size()], gmis::SquareTable<T>(masses, 0.1),
                      gmis::Aim<T>(centre, radii)});
  }
  return {lights, T(0.3)};
}

/// The density of the start from a node of a light to a surface under the guide, over that of the
/// light alone: with the probability s as the light has it, else
///   (probability of the light) · (density of its numbers) · (1/16 per ring)
///     / (solid angle or area of the ring),
/// or as the light has it for a ring that begins beyond the point.
template <class World>
[[nodiscard]] long double guide_ratio(const gmis::EmissionGuide<World>& guide, const World& world,
                                      const DiscreteAtlas<long double>& atlas, std::size_t node, std::size_t surface) {
  using Kind = typename World::Kind;
  using V = gmis::Vec3<long double>;
  const auto& light_node = atlas.nodes[node];
  const long double own = static_cast<long double>(guide.own_share()), pi = gmis::pi<long double>;
  for (const auto& guided : guide.lights()) {
    if (static_cast<int>(guided.light->kind()) != static_cast<int>(light_node.kind)) continue;
    const V centre(guided.aim.centre()), at = atlas.nodes[surface].position;
    const V direction = light_node.is_infinite ? -light_node.position : glm::normalize(at - light_node.position);
    const long double past = glm::length((centre - at) - direction * glm::dot(centre - at, direction));
    const auto& radii = guided.aim.radii();
    std::size_t ring = 0;
    while (ring < 16 && static_cast<long double>(radii[ring + 1]) < past) ++ring;
    long double aimed = 0.0L;
    const auto radius = [&](std::size_t k) { return static_cast<long double>(radii[k]); };
    if (light_node.is_infinite) {
      if (ring < 16) aimed = 1.0L / (16.0L * pi * (std::pow(radius(ring + 1), 2.0L) - std::pow(radius(ring), 2.0L)));
    } else {
      const long double distance = glm::length(centre - light_node.position);
      const auto cosine = [&](std::size_t k) {
        return radius(k) < distance ? std::cos(std::asin(radius(k) / distance)) : 0.0L;
      };
      if (ring < 16 && radius(ring) < distance && glm::dot(centre - light_node.position, direction) > 0.0L)
        aimed = 1.0L / (16.0L * 2.0L * pi * (cosine(ring) - cosine(ring + 1)));
    }
    aimed /= atlas.emission_first_density(node, direction);
    if (!light_node.is_infinite)
      for (std::size_t k = 0; k < 16; ++k)
        if (radius(k) >= glm::length(centre - light_node.position)) aimed += 1.0L / 16.0L;
    if (light_node.kind != static_cast<DiscreteAtlas<long double>::Kind>(Kind::point_light) &&
        light_node.kind != static_cast<DiscreteAtlas<long double>::Kind>(Kind::sun)) {
      const auto numbers = World::Light::atlas_numbers(node);
      aimed *= static_cast<long double>(guided.first.bins()[static_cast<std::size_t>(16 * numbers.y) * 16 +
                                                            static_cast<std::size_t>(16 * numbers.x)]);
    }
    const long double chosen = static_cast<long double>(guided.probability) /
                               static_cast<long double>(world.selection_probability(*guided.light));
    return own + (1.0L - own) * chosen * aimed;
  }
  return own;
}

}  // namespace gmis_test
