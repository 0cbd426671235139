#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gmis/core/attributes.hpp"
#include "gmis/core/interaction.hpp"
#include "gmis/scene/alias_table.hpp"
#include "gmis/scene/light_bounds.hpp"

namespace gmis::scene {

template <std::floating_point T>
class LightHierarchyBuilder;

/// Chooses one of many lights for a receiver, by power, distance and orientation: a binary tree
/// over all lights that have a position, with bounds of place and direction in every node [Conty
/// Estevez, Kulla, Importance sampling of many lights with adaptive tree splitting, 2018]. A
/// choice, and the probability of one, cost a walk from the root to a leaf. A leaf holds one light
/// or a few that belong together, which are chosen by power. Infinite lights are
/// chosen by power, with a fixed probability of all together. `LightHierarchyBuilder` makes it.
///
/// The probability of a light is positive wherever the light reaches: bounds are conservative. Both
/// sides of the receiver count alike, because it may transmit light.
template <std::floating_point T>
class LightHierarchy {
 public:
  using Point = SurfacePoint<T>;
  /// A light that was chosen.
  struct Choice {
    std::size_t light;  ///< number of the light
    T probability;      ///< of choosing it, positive
  };

  /// True when the choice depends on the receiver: the tree has more than one leaf.
  [[nodiscard]] bool has_choice() const noexcept { return nodes_.size() > 1; }
  /// True when there is no light.
  [[nodiscard]] bool is_empty() const noexcept { return places_.empty(); }

  /// A light for a next event at `from`, with `u` in [0, 1). With float, `u` has 24
  /// bits: lights with a probability near 2^-24 are chosen at some receivers only.
  [[nodiscard]] GMIS_NEVER_INLINE Choice sample(const Point& from, T u) const noexcept {
    if (u < infinite_probability_) {
      const std::size_t i = infinite_choice_.sample(std::min(u / infinite_probability_, below_one));
      return Choice{infinite_lights_[i], places_[infinite_lights_[i]].fixed_probability};
    }
    T rest = std::min((u - infinite_probability_) / (T(1) - infinite_probability_), below_one);
    T probability = T(1) - infinite_probability_;
    std::uint32_t at = 0;
    while (!nodes_[at].is_leaf()) {
      const std::uint32_t left = nodes_[at].first;
      const T share = share_of_left(left, from);
      const bool goes_left = rest < share;
      const T chosen = goes_left ? share : T(1) - share;
      rest = std::min((goes_left ? rest : rest - share) / chosen, below_one);
      probability *= chosen;
      at = goes_left ? left : left + 1;
    }
    std::size_t light = nodes_[at].first & ~leaf_bit;
    for (; !places_[light].is_last && !(rest < places_[light].fixed_probability); ++light)
      rest -= places_[light].fixed_probability;
    return Choice{light, probability * places_[light].fixed_probability};
  }

  /// The probability with which `sample(from, u)` chooses the light.
  [[nodiscard]] GMIS_NEVER_INLINE T probability(std::size_t light, const Point& from) const noexcept {
    const Place& place = places_[light];
    if (!place.is_in_tree) return place.fixed_probability;
    T probability = T(1) - infinite_probability_;
    std::uint64_t path = place.path;
    for (std::uint32_t at = 0; !nodes_[at].is_leaf(); path >>= 1U) {
      const std::uint32_t left = nodes_[at].first;
      const T share = share_of_left(left, from);
      const bool goes_left = (path & 1U) == 0;
      probability *= goes_left ? share : T(1) - share;
      at = goes_left ? left : left + 1;
    }
    return probability * place.fixed_probability;
  }

  /// Memory of nodes and lights.
  [[nodiscard]] std::size_t byte_count() const noexcept {
    return nodes_.size() * sizeof(Node) + places_.size() * sizeof(Place);
  }

 private:
  friend class LightHierarchyBuilder<T>;
  static constexpr std::uint32_t leaf_bit = std::uint32_t{1} << 31U;
  static constexpr T below_one = T(1) - std::numeric_limits<T>::epsilon() / T(2);

  struct Node {
    Vec3<T> center;
    T radius_squared;  ///< of a ball around the box
    Vec3<T> axis;
    T cos_spread, sin_spread;
    T cos_emission;
    T power;
    std::uint32_t first;  ///< the left child, with the right one behind it; in a leaf the first light, with `leaf_bit`
    [[nodiscard]] bool is_leaf() const noexcept { return (first & leaf_bit) != 0; }
  };
  struct Place {
    std::uint64_t path = 0;      ///< from the root, lowest bit first: 1 is right
    T fixed_probability = T(0);  ///< of this light within its leaf; of an infinite light, among all
    bool is_in_tree = false;
    bool is_last = true;  ///< in its leaf
  };

  /// Bound of the irradiance that the lights of a node make at `from`, up to a factor: power · cos
  /// θ' · cos θ_i' / d² [Conty Estevez, Kulla 2018, eq. 3]. Angles are the least that the ball
  /// around the node allows. 0 only where no light of the node shines.
  [[nodiscard]] T importance(const Node& node, const Point& from) const noexcept {
    const Vec3<T> offset = node.center - from.position;
    const T distance_squared = glm::dot(offset, offset);
    const T strength = node.power / std::max(std::max(distance_squared, node.radius_squared), least_square_);
    if (distance_squared <= node.radius_squared || !(distance_squared > T(0))) return strength;
    const Vec3<T> to_node = offset * (T(1) / std::sqrt(distance_squared));
    const T sin2_ball = node.radius_squared / distance_squared;
    const T cos_ball = std::sqrt(T(1) - sin2_ball), sin_ball = std::sqrt(sin2_ball);

    T emitted(1);
    if (node.cos_spread > T(-1)) {
      const T from_axis = std::clamp(-glm::dot(node.axis, to_node), T(-1), T(1));
      const T beyond_spread = less(from_axis, node.cos_spread, node.sin_spread);
      emitted = less(beyond_spread, cos_ball, sin_ball);
      constexpr T rounding = T(1e-3);
      if (emitted < node.cos_emission - rounding) return T(0);
    }
    const T received = less(std::min(std::abs(glm::dot(from.geometric_normal, to_node)), T(1)), cos_ball, sin_ball);
    // The floors keep probabilities away from 0 where a bound is loose or the shading normal is
    // another.
    return strength * std::max(emitted, T(0.01)) * std::max(received, T(0.05));
  }
  /// cos(max(a − b, 0)) from cos a, and cos b and sin b; angles between 0 and π.
  [[nodiscard]] static T less(T cos_a, T cos_b, T sin_b) noexcept {
    if (cos_a >= cos_b) return T(1);
    return cos_a * cos_b + sqrt_or_zero(T(1) - cos_a * cos_a) * sin_b;
  }
  /// The probability of the left one of two siblings. It is above 0 where its lights shine at
  /// `from`; where neither does, both are as likely.
  [[nodiscard]] T share_of_left(std::uint32_t left, const Point& from) const noexcept {
    constexpr T least = T(4) * std::numeric_limits<T>::epsilon();
    const T a = importance(nodes_[left], from), b = importance(nodes_[left + 1], from);
    if (!(a + b > T(0))) return T(0.5);
    const T share = a / (a + b);
    return a > T(0) && b > T(0) ? std::clamp(share, least, T(1) - least) : share;
  }

  std::vector<Node> nodes_;
  std::vector<Place> places_;  ///< by number of the light
  std::vector<std::size_t> infinite_lights_;
  AliasTable<T> infinite_choice_;
  T infinite_probability_ = T(0);
  T least_square_ = T(0);  ///< distances count as at least the root of this
};

}  // namespace gmis::scene
