#pragma once

#include <array>
#include <cmath>
#include <gmis/core/random.hpp>
#include <numbers>

// The estimator of docs/test-your-estimator.md: written as one would without the library.

struct Normal {
  double mean, deviation;
  double sample(gmis::UniformSource auto& source) const {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - gmis::uniform<double>(source)));
    return mean + deviation * radius * std::cos(2.0 * std::numbers::pi * gmis::uniform<double>(source));
  }
  double pdf(double x) const {
    const double z = (x - mean) / deviation;
    return std::exp(-0.5 * z * z) / (deviation * std::sqrt(2.0 * std::numbers::pi));
  }
};

inline double f(double x) {
  return std::exp(-x * x / 7.0);
}

struct MyEstimator {
  std::array<Normal, 2> proposals{{{-1.5, 2.0}, {1.0, 1.5}}};
  std::array<double, 2> counts{3.0, 1.0};
  std::array<double, 2> counts_in_weight = counts;    // planted bug: {1, 1}
  std::array<Normal, 2> samplers = proposals;         // planted bug: a deviation that is 2 % too large
  std::array<double, 2> counts_in_division = counts;  // planted bug: {1, 1}
  double lost = 1e9;                                  // planted bug: samples beyond it count as zero

  double round(gmis::Philox& source) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      for (int i = 0; i < static_cast<int>(counts[k]); ++i) {
        const double x = samplers[k].sample(source);
        const double q[2] = {proposals[0].pdf(x), proposals[1].pdf(x)};
        const double all = counts_in_weight[0] * q[0] + counts_in_weight[1] * q[1];
        const double weight = counts_in_weight[k] * q[k] / all;
        if (x < lost) sum += weight * f(x) / (counts_in_division[k] * q[k]);
      }
    return sum;
  }
};
