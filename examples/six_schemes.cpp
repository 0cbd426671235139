#include <array>
#include <cmath>
#include <cstdio>
#include <gmis/mis.hpp>
#include <gmis/mis/location_scale.hpp>

int main() {
  const std::array means{-3.0, 0.0, 3.0}, deviations{2.0, 2.0, 2.0};
  const gmis::LocationScaleSet<gmis::shapes::Normal> proposals(means, deviations);
  const auto f = [](double x) { return std::exp(-0.2 * x * x) * (1.0 + 0.5 * std::sin(3.0 * x)); };
  for (const gmis::Scheme scheme : gmis::all_schemes) {
    gmis::Philox source(1);
    const auto estimate = gmis::estimate(scheme, f, proposals, 100'000, source);
    std::printf("%s  %.4f, error %.4f\n", name_of(scheme).data(), estimate.mean, estimate.standard_error.value());
  }
}
