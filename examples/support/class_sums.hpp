#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gmis/transport/effects/class_costs.hpp"
#include "support/render.hpp"

namespace gmis::tools {

/// Sums of what each path class gave, over all iterations.
class ClassSums {
 public:
  ClassSums(glm::ivec2 resolution, PixelBounds crop) : resolution_(resolution), crop_(crop) {}

  template <class S>
  void add(const Contribution<S>& contribution) {
    const auto number = static_cast<std::size_t>(contribution.id.path_class);
    if (number >= path_class_count) return;  // the integrator does not tell
    work_[number].add(contribution.id);
    std::vector<double>& sum = sums_[number];
    if (sum.empty()) sum.resize(3 * static_cast<std::size_t>(resolution_.x) * static_cast<std::size_t>(resolution_.y));
    for (int c = 0; c < 3; ++c)
      sum[3 * static_cast<std::size_t>(contribution.pixel) + static_cast<std::size_t>(c)] +=
          static_cast<double>(contribution.value[c] * contribution.weight);
  }

  /// The classes that had any contribution, in the order of their numbers. `work` and `light_work` as `costs_of_classes`
  /// has them.
  [[nodiscard]] PathClassResult result(std::uint32_t iterations, const Counters& work,
                                       const Counters& light_work) const {
    const ClassCosts costs = costs_of_classes(work_, work, light_work);
    const double whole = cost_of(work);
    const auto share = [whole](double cost) { return whole > 0 ? cost / whole : 0; };
    PathClassResult result;
    result.unattributed_cost = share(costs.unattributed);
    for (std::size_t i = 0; i < path_class_count; ++i) {
      if (sums_[i].empty()) continue;
      Image image(resolution_.x, resolution_.y);
      for (std::size_t j = 0; j < sums_[i].size(); ++j) image.rgb[j] = static_cast<float>(sums_[i][j] / iterations);
      result.classes.push_back({static_cast<PathClass>(i),
                                cropped(image, crop_.lower.x, crop_.lower.y, crop_.upper.x, crop_.upper.y),
                                work_[i].total(), share(costs.classes[i])});
    }
    return result;
  }

 private:
  glm::ivec2 resolution_;
  PixelBounds crop_;
  std::array<std::vector<double>, path_class_count> sums_;
  std::array<ClassWork, path_class_count> work_{};
};

}  // namespace gmis::tools
