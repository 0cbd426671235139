#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/synthetic_path.hpp"

// The paper's recursion for w_{i,VC} and w_{i,VM}, as printed and as corrected, against the
// brute-force sum over techniques. Paths of the paper's own kind: no delta vertices, equal counts
// for all techniques of vertex connection.

namespace {

using Wide = long double;

struct LightSide {
  std::vector<Wide> connection, merging;  ///< w_{i,VC}, w_{i,VM}
};

/// η = n_VM / n_VC π r². The corrected form divides by p→_i where the printed one multiplies.
LightSide recursion(const gmis::PathDensities<Wide>& path, Wide eta, bool as_printed) {
  const auto& a = path.from_light;
  const auto& b = path.from_camera;
  LightSide w;
  w.connection.push_back(b[0] / a[0]);
  w.merging.push_back(0);
  for (std::size_t i = 1; i < a.size(); ++i) {
    w.connection.push_back(b[i] * (eta + 1 / a[i] + w.connection[i - 1] / a[i]));
    const Wide factor = as_printed ? a[i] : 1 / a[i];
    w.merging.push_back(i == 1 ? factor * (1 / eta + b[0] / (eta * a[0]))
                               : factor * (1 / eta + b[i - 1] + b[i - 1] * w.merging[i - 1]));
  }
  return w;
}

/// The ratios that the paper's recursions claim to be: the densities of all techniques to the left
/// over that of connecting behind x_i, or merging at x_i.
LightSide by_force(const gmis::PathDensities<Wide>& path, Wide eta) {
  const auto k = path.from_light.size();
  gmis::TechniqueCounts<Wide> counts{1, 1, 1, 1, eta};
  const auto all = gmis::technique_densities(path, counts);
  const auto connect = [&](std::size_t s) { return all[s].density; };
  const auto merge = [&](std::size_t i) { return all[k + i].density; };
  LightSide w;
  w.merging.push_back(0);
  for (std::size_t i = 0; i < k; ++i) {
    Wide left = 0;
    for (std::size_t s = 0; s <= i; ++s) left += connect(s);
    for (std::size_t m = 1; m < i; ++m) left += merge(m);
    if (i > 0) w.merging.push_back(left / merge(i));
    if (i > 0) left += merge(i);
    w.connection.push_back(left / connect(i + 1));
  }
  return w;
}

double worst(const std::vector<Wide>& found, const std::vector<Wide>& expected) {
  Wide result = 0;
  for (std::size_t i = 1; i < expected.size(); ++i)
    result = std::max(result, std::abs(std::log(found[i] / expected[i])));
  return static_cast<double>(std::exp(result) - 1);
}

}  // namespace

TEST_CASE("the merging weights are off by orders of magnitude as printed, and exact with 1/p in place of p") {
  std::mt19937_64 source(gmis_test::seed(5));
  std::vector<double> printed_errors;
  for (int n = 0; n < 500; ++n) {
    auto invented = gmis_test::random_path<double>(source, 2 + n % 8, 1.0, 0.0);
    invented.next_event = invented.origin;
    invented.light_can_be_hit = true;
    const auto path = gmis_test::path_densities<Wide>(invented);
    const Wide eta = std::pow(10.0L, -4.0L + static_cast<Wide>(n % 5));
    const LightSide expected = by_force(path, eta);
    const LightSide corrected = recursion(path, eta, false);
    CHECK(worst(corrected.connection, expected.connection) < 1e-12);
    CHECK(worst(corrected.merging, expected.merging) < 1e-12);
    printed_errors.push_back(worst(recursion(path, eta, true).merging, expected.merging));
  }
  std::sort(printed_errors.begin(), printed_errors.end());
  CAPTURE(printed_errors.front(), printed_errors[250], printed_errors.back());
  CHECK(printed_errors[25] > 1.0);    // 95 % of the paths are off by more than a factor of 2 …
  CHECK(printed_errors[250] > 10.0);  // … and half of them by more than one of 10
}

TEST_CASE("the two partial sums of the paper are one sum over absolute counts") {
  // weights/weight_formulas.hpp: w_VC = L / ρ, w_VM = (L / b − μ) / μ, with L the densities to
  // the left over U(i+1).
  std::mt19937_64 source(gmis_test::seed(6));
  for (int n = 0; n < 200; ++n) {
    auto invented = gmis_test::random_path<double>(source, 2 + n % 8, 1.0, 0.0);
    invented.next_event = invented.origin;
    invented.light_can_be_hit = true;
    const auto path = gmis_test::path_densities<Wide>(invented);
    const Wide mu = 0.37L;
    const LightSide w = recursion(path, mu, false);
    const gmis::WeightRecursion<double> weights({1.0, 1.0, 1.0, 1.0, static_cast<double>(mu)});
    const auto a = [&](std::size_t i) { return static_cast<double>(path.from_light[i]); };
    auto partial =
        weights.first_light_vertex({invented.origin, invented.next_event, a(1)}, invented.to_area_from_camera[0]);
    for (std::size_t i = 1; i < path.from_light.size(); ++i) {
      const double left = partial.shared.value() + invented.reverse[i] * partial.chain.value();  // L_i / b_i − μ
      CHECK(left / static_cast<double>(mu) == Approx(static_cast<double>(w.merging[i])).epsilon(1e-12));
      CHECK((left + static_cast<double>(mu)) * static_cast<double>(path.from_camera[i]) ==
            Approx(static_cast<double>(w.connection[i])).epsilon(1e-12));
      if (i + 1 < path.from_light.size())
        partial = weights.extend_light(partial,
                                       {true, false, invented.reverse[i], invented.to_area_from_camera[i], a(i + 1)});
    }
  }
}
