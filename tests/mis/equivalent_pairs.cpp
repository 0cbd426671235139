#include <array>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::Selection;
using gmis::Weighting;

constexpr std::size_t round_count = 6000;

/// Single-round estimates of a problem on which the six schemes differ strongly.
std::vector<double> round_estimates(Selection selection, Weighting weighting, std::uint64_t seed) {
  const std::array<test::Bump, 3> proposals{{{0.0, 0.2, 0.2}, {0.4, 0.6, 0.2}, {0.7, 1.0, 0.2}}};
  const auto f = [](double x) { return x < 0.2 ? 3.0 + x : x > 0.55 ? 2.0 * x : 0.5; };
  gmis::Philox source(gmis_test::seed(seed));
  std::vector<double> values(round_count);
  for (double& value : values) value = gmis::estimate(selection, weighting, f, proposals, 1, source).mean;
  return values;
}

}  // namespace

// Nine comparisons, Kolmogorov–Smirnov on the estimates of single rounds; the family raises a false
// alarm with probability 1e-4 over seeds.
TEST_CASE("pairs of one scheme agree in distribution", "[mis]") {
  std::array<std::vector<double>, 6> first;
  std::array<std::string, 6> first_name;
  const double level = test::sidak_level(1e-4, 9);
  std::size_t comparisons = 0;
  std::uint64_t seed = 100;
  for (const Selection selection : gmis::all_selections)
    for (const Weighting weighting : gmis::all_weightings) {
      const auto scheme = static_cast<std::size_t>(scheme_of(selection, weighting));
      std::vector<double> values = round_estimates(selection, weighting, ++seed);
      const std::string name = std::string(name_of(selection)) + std::string(name_of(weighting));
      if (first[scheme].empty()) {
        first[scheme] = std::move(values);
        first_name[scheme] = name;
        continue;
      }
      CAPTURE(first_name[scheme], name);
      CHECK(test::kolmogorov_smirnov_p_value(first[scheme], values) > level);
      ++comparisons;
    }
  CHECK(comparisons == 9);

  // The same test does tell different schemes apart, all pairs but R1 and N1 (whose variances are
  // equal).
  for (std::size_t a = 0; a < 6; ++a)
    for (std::size_t b = a + 1; b < 6; ++b) {
      if (gmis::all_schemes[a] == gmis::Scheme::R1 && gmis::all_schemes[b] == gmis::Scheme::N1) continue;
      CAPTURE(first_name[a], first_name[b]);
      CHECK(test::kolmogorov_smirnov_p_value(first[a], first[b]) < level);
    }
}
