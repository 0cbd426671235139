#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "gmis/transport/candidate.hpp"

/// \file
/// What a choice by region of the picture could gain. Error times cost is a product of sums over regions, so regions cannot
/// choose apart from each other. But where the product V C is least, so is V C* + C V*, the best ones' values fixed: by the
/// means' inequality V C* + C V* ≥ 2 √(V C V* C*) ≥ 2 V* C*. So with the right exchange rate V*/C* each region chooses for
/// itself, and the rate follows from what they chose.

namespace gmis {

struct VarianceAndCost {
  double variance = 0.0, cost = 0.0;
  [[nodiscard]] double work() const noexcept { return variance * cost; }
};

/// The least variance × cost when every region has its choice of `regions[r]`, and `shared_cost` is added to theirs; no less
/// than the true least, and that itself where the search from each choice's own rate leads there. Every region needs a
/// choice; without regions the variance is 0.
[[nodiscard]] inline VarianceAndCost least_work_by_region(const std::vector<std::vector<VarianceAndCost>>& regions,
                                                          double shared_cost) {
  const auto choose = [&](double rate) {
    VarianceAndCost sum{0.0, shared_cost};
    for (const auto& choices : regions) {
      VarianceAndCost best;
      double least = std::numeric_limits<double>::infinity();
      for (const VarianceAndCost& choice : choices)
        if (const double price = choice.variance + rate * choice.cost; price < least) {
          least = price;
          best = choice;
        }
      sum.variance += best.variance;
      sum.cost += best.cost;
    }
    return sum;
  };
  VarianceAndCost least = choose(0.0);
  for (const auto& choices : regions)
    for (const VarianceAndCost& start : choices) {
      if (!(start.cost > 0.0)) continue;
      VarianceAndCost now = choose(start.variance / start.cost);
      for (double before = std::numeric_limits<double>::infinity(); now.work() < before && now.cost > 0.0;) {
        before = now.work();
        if (now.work() < least.work()) least = now;
        now = choose(now.variance / now.cost);
      }
    }
  return least;
}

}  // namespace gmis
