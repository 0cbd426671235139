#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

/// \file
/// What a choice by region of the picture could gain. Error times cost is a product of sums over regions, so regions cannot
/// choose apart from each other. But where the product V C is least, so is V C* + C V*, the best ones' values fixed: by the
/// means' inequality V C* + C V* ≥ 2 √(V C V* C*) ≥ 2 V* C*. So with the right exchange rate V*/C* each region chooses for
/// itself, and what it chooses changes only at the slopes of its own choices' convex hull.

namespace gmis {

struct VarianceAndCost {
  double variance = 0.0, cost = 0.0;
  [[nodiscard]] double work() const noexcept { return variance * cost; }
};

/// Those that are best at some rate: the lower hull, by rising cost and falling variance.
[[nodiscard]] inline std::vector<VarianceAndCost> lower_hull(std::vector<VarianceAndCost> choices) {
  std::sort(choices.begin(), choices.end(), [](const VarianceAndCost& a, const VarianceAndCost& b) {
    return a.cost != b.cost ? a.cost < b.cost : a.variance < b.variance;
  });
  std::vector<VarianceAndCost> hull;
  for (const VarianceAndCost& next : choices) {
    if (!hull.empty() && next.variance >= hull.back().variance) continue;
    const auto is_above = [&](const VarianceAndCost& a, const VarianceAndCost& b) {
      return (b.variance - a.variance) * (next.cost - a.cost) >= (next.variance - a.variance) * (b.cost - a.cost);
    };
    while (hull.size() >= 2 && is_above(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(next);
  }
  return hull;
}

/// The least variance × cost when every region has its choice of `regions[r]`, none of them empty, and `shared_cost` is added
/// to theirs; the variances of all regions add up. Without regions the variance is 0.
[[nodiscard]] inline VarianceAndCost least_work_by_region(const std::vector<std::vector<VarianceAndCost>>& regions,
                                                          double shared_cost) {
  std::vector<std::vector<VarianceAndCost>> hulls;
  std::vector<double> slopes{0.0};
  for (const auto& choices : regions) {
    hulls.push_back(lower_hull(choices));
    const auto& hull = hulls.back();
    for (std::size_t i = 1; i < hull.size(); ++i)
      slopes.push_back((hull[i - 1].variance - hull[i].variance) / (hull[i].cost - hull[i - 1].cost));
  }
  std::sort(slopes.begin(), slopes.end());
  const auto chosen_at = [&](double rate) {
    VarianceAndCost sum{0.0, shared_cost};
    for (const auto& hull : hulls) {
      const auto best = std::min_element(hull.begin(), hull.end(), [&](const auto& a, const auto& b) {
        return a.variance + rate * a.cost < b.variance + rate * b.cost;
      });
      sum.variance += best->variance;
      sum.cost += best->cost;
    }
    return sum;
  };
  VarianceAndCost least = chosen_at(2.0 * slopes.back() + 1.0);
  for (std::size_t i = 1; i < slopes.size(); ++i)  // between two slopes nothing changes
    if (const VarianceAndCost now = chosen_at(0.5 * (slopes[i - 1] + slopes[i])); now.work() < least.work())
      least = now;
  return least;
}

}  // namespace gmis
