#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "gmis/scene/light.hpp"
#include "gmis/scene/light_hierarchy.hpp"
#include "gmis/scene/light_selection.hpp"

namespace gmis::scene {

/// Builds a `LightHierarchy` from the top down: each group is cut where the surface area
/// orientation heuristic is least, among 12 bins along each axis [Conty Estevez, Kulla 2018].
template <std::floating_point T>
class LightHierarchyBuilder {
 public:
  /// `Light::selection_probability` of infinite lights is not read: they are chosen by power.
  /// Lights that follow each other with the same number in `groups`, at most 8 of them, share a
  /// leaf: the triangles of a lamp. Without `groups` each light has a leaf.
  [[nodiscard]] static LightHierarchy<T> build(std::span<const Light<T>> lights,
                                               std::span<const std::size_t> groups = {}) {
    LightHierarchyBuilder builder(lights, groups);
    return std::move(builder.made_);
  }

 private:
  using Node = typename LightHierarchy<T>::Node;
  struct Leaf {
    LightBounds bounds;
    glm::dvec3 middle;
    std::uint32_t light;      ///< the first one
    std::uint32_t count = 1;  ///< lights with successive numbers
  };
  using Range = std::span<Leaf>;
  static constexpr int bin_count = 12;
  /// Below, groups are halved: paths have 64 bits, and the 24 levels that are left have room for
  /// 2^24 lights.
  static constexpr int deepest_bins = 40;

  LightHierarchyBuilder(std::span<const Light<T>> lights, std::span<const std::size_t> groups) {
    made_.places_.resize(lights.size());
    std::vector<double> infinite_powers;
    double infinite_power = 0, power = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (!(lights[i].power() > 0)) continue;
      if (lights[i].is_infinite()) {
        made_.infinite_lights_.push_back(i);
        infinite_powers.push_back(lights[i].power_to_choose_by());
        infinite_power += infinite_powers.back();
        continue;
      }
      const LightBounds bounds = lights[i].bounds();
      power += bounds.power;
      made_.places_[i].is_in_tree = true;
      if (!groups.empty() && !leaves_.empty() && groups[leaves_.back().light] == groups[i] &&
          leaves_.back().light + leaves_.back().count == i && leaves_.back().count < 8) {
        leaves_.back().bounds = LightBounds::of_both(leaves_.back().bounds, bounds);
        ++leaves_.back().count;
      } else {
        leaves_.push_back({bounds, {}, static_cast<std::uint32_t>(i)});
      }
    }
    for (Leaf& leaf : leaves_) {
      leaf.middle = (leaf.bounds.box.lower + leaf.bounds.box.upper) * 0.5;
      for (std::uint32_t k = 0; k < leaf.count; ++k) {
        auto& place = made_.places_[leaf.light + k];
        place.fixed_probability = static_cast<T>(lights[leaf.light + k].power() / leaf.bounds.power);
        place.is_last = k + 1 == leaf.count;
      }
    }
    if (!infinite_powers.empty()) {
      made_.infinite_choice_ = AliasTable<T>(infinite_powers);
      // Neither a sky nor the lamps can be starved.
      const double share = balanced_infinite_share(infinite_power, infinite_powers.size(), power);
      made_.infinite_probability_ = static_cast<T>(share);
      const std::vector<double> chances = made_.infinite_choice_.realised_probabilities();
      for (std::size_t k = 0; k < chances.size(); ++k)
        made_.places_[made_.infinite_lights_[k]].fixed_probability =
            made_.infinite_probability_ * static_cast<T>(chances[k]);
    }
    if (leaves_.empty()) return;
    Box<double> box;
    for (const Leaf& leaf : leaves_) box.add(leaf.bounds.box);
    const glm::dvec3 size = box.upper - box.lower;
    const double square = std::max(glm::dot(size, size), 1e-12);
    // Only ratios count. These scales keep them in the range of float.
    for (Leaf& leaf : leaves_) leaf.bounds.power = std::max(leaf.bounds.power / power, 1e-12) * square;
    made_.least_square_ = static_cast<T>(1e-8 * square);
    made_.nodes_.resize(2 * leaves_.size() - 1);
    add(0, leaves_, 0, 0);
  }

  /// Fills node `at` with a group, which `path` leads to, and returns its bounds.
  LightBounds add(std::size_t at, Range group, std::uint64_t path, int depth) {
    LightBounds bounds;
    if (group.size() == 1) {
      bounds = group[0].bounds;
      for (std::uint32_t k = 0; k < group[0].count; ++k) made_.places_[group[0].light + k].path = path;
      fill(at, bounds, group[0].light | LightHierarchy<T>::leaf_bit);
      return bounds;
    }
    const std::size_t middle = cut(group, depth);
    const std::size_t left = next_;
    next_ += 2;
    const LightBounds first = add(left, group.first(middle), path, depth + 1);
    const LightBounds second =
        add(left + 1, group.subspan(middle), path | (std::uint64_t{1} << static_cast<unsigned>(depth)), depth + 1);
    bounds = LightBounds::of_both(first, second);
    fill(at, bounds, static_cast<std::uint32_t>(left));
    return bounds;
  }
  void fill(std::size_t at, const LightBounds& bounds, std::uint32_t first) {
    const glm::dvec3 half = (bounds.box.upper - bounds.box.lower) * 0.5;
    // Rounded outwards.
    const double spread = bounds.spread >= pi<double> - 1e-4 ? pi<double> : bounds.spread;
    made_.nodes_[at] = {Vec3<T>(bounds.box.lower + half),
                        static_cast<T>(glm::dot(half, half) * 1.0001),
                        Vec3<T>(bounds.axis),
                        spread == pi<double> ? T(-1) : static_cast<T>(std::cos(spread)),
                        static_cast<T>(std::sin(spread)),
                        static_cast<T>(std::cos(std::min(bounds.emission, pi<double>))),
                        static_cast<T>(bounds.power),
                        first};
  }

  /// Orders a group and says how many of it go left.
  [[nodiscard]] std::size_t cut(Range group, int depth) const {
    Box<double> middles;
    for (const Leaf& leaf : group) middles.add(leaf.middle);
    const glm::dvec3 size = middles.upper - middles.lower;
    const double longest = std::max({size.x, size.y, size.z});
    int best_axis = size.x == longest ? 0 : size.y == longest ? 1 : 2, best_bin = -1;
    double best_cost = std::numeric_limits<double>::infinity();
    const auto bin_of = [&](const Leaf& leaf, int axis) {
      const double place = (leaf.middle[axis] - middles.lower[axis]) / size[axis] * bin_count;
      return std::clamp(static_cast<int>(place), 0, bin_count - 1);
    };
    for (int axis = 0; axis < 3 && depth < deepest_bins; ++axis) {
      if (!(size[axis] > 0)) continue;
      std::array<LightBounds, bin_count> bins{};
      for (const Leaf& leaf : group) {
        LightBounds& bin = bins[static_cast<std::size_t>(bin_of(leaf, axis))];
        bin = LightBounds::of_both(bin, leaf.bounds);
      }
      std::array<double, bin_count> right_cost{};
      LightBounds side;
      for (std::size_t i = bin_count; i-- > 1;) {
        side = LightBounds::of_both(side, bins[i]);
        right_cost[i] = side.cost();
      }
      side = {};
      for (std::size_t i = 0; i + 1 < bin_count; ++i) {
        side = LightBounds::of_both(side, bins[i]);
        if (side.box.is_empty()) continue;
        // Thin boxes are cut across their length.
        const double cost = longest / size[axis] * (side.cost() + right_cost[i + 1]);
        if (!(cost < best_cost)) continue;
        best_cost = cost;
        best_axis = axis;
        best_bin = static_cast<int>(i);
      }
    }
    if (best_bin >= 0) {
      const auto middle = std::partition(group.begin(), group.end(),
                                         [&](const Leaf& leaf) { return bin_of(leaf, best_axis) <= best_bin; });
      const auto count = static_cast<std::size_t>(middle - group.begin());
      if (count > 0 && count < group.size()) return count;
    }
    const std::size_t half = group.size() / 2;
    std::nth_element(group.begin(), group.begin() + static_cast<std::ptrdiff_t>(half), group.end(),
                     [&](const Leaf& a, const Leaf& b) { return a.middle[best_axis] < b.middle[best_axis]; });
    return half;
  }

  std::vector<Leaf> leaves_;
  LightHierarchy<T> made_;
  std::size_t next_ = 1;
};

}  // namespace gmis::scene
