// Prints the processor time of 100,000 rounds of N3 over three normal proposals, the least of 15
// runs, and the estimate: time_rounds.py compares Python with it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "gmis/mis.hpp"
#include "gmis/mis/location_scale.hpp"

int main() {
  const std::array means{-3.0, 0.0, 3.0}, deviations{2.0, 2.0, 2.0};
  const gmis::LocationScaleSet<gmis::shapes::Normal> proposals(means, deviations);
  const auto f = [](double x) { return std::exp(-0.2 * x * x) * (1.0 + 0.5 * std::sin(3.0 * x)); };
  double least = 1e9, mean = 0.0;
  for (int run = 0; run < 15; ++run) {
    gmis::Philox source(1);
    const std::clock_t start = std::clock();
    mean = gmis::estimate<gmis::Scheme::N3>(f, proposals, 100'000, source).mean;
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::printf("%.17g %.17g\n", least, mean);
  return 0;
}
