#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "gmis/mis.hpp"
#include "hostile/denominator_oracle.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The denominators of all fifteen pairs against long double, for densities anywhere in the range of
// their type. The oracle knows the indices that a round drew, and works each denominator out from
// its definition.

namespace {

using Wide = long double;
using gmis::Scheme;

/// A density that is the same everywhere, given itself or by its logarithm.
template <class T>
struct Constant {
  T value;
  int sample(gmis::UniformSource auto&) const { return 0; }
  T pdf(int) const { return value; }
};
struct LogConstant {
  double log_value;
  int sample(gmis::UniformSource auto&) const { return 0; }
  double log_pdf(int) const { return log_value; }
};

/// The worst relative error of a denominator over one round of every pair.
template <class P, class Read>
double worst_error(const std::vector<P>& proposals, const std::vector<Wide>& exact, std::uint64_t seed, Read read) {
  double worst = 0.0;
  const auto set = gmis::as_proposal_set(proposals);
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      gmis::Philox source(gmis_test::seed(seed));
      gmis::Workspace<typename decltype(set)::Density, gmis::dynamic_capacity> workspace;
      std::vector<std::size_t> drawn;
      std::vector<Wide> denominators;
      dispatch(selection, weighting, [&](auto s, auto w) {
        const auto counts = gmis::sample_round<decltype(s)::value, decltype(w)::value>(
            set, gmis::EqualAllocation{}, source, workspace, [&](int, auto phi, std::size_t index) {
              drawn.push_back(index);
              denominators.push_back(read(phi));
            });
        CHECK(counts.zero_density + counts.non_finite_density == 0);
      });
      REQUIRE(drawn.size() == proposals.size());
      // A long sum costs the oracle N² additions in N2: every sample of a short round, some of a
      // long one.
      const std::size_t step = std::max<std::size_t>(1, drawn.size() / 64);
      for (std::size_t n = 0; n < drawn.size(); n += step) {
        const Wide expected = hostile::denominator(gmis::scheme_of(selection, weighting), exact.size(), drawn, n,
                                                   [&](std::size_t k) { return exact[k]; });
        worst = std::max(worst, static_cast<double>(std::abs(denominators[n] / expected - 1.0L)));
      }
    }
  return worst;
}

template <class T>
double worst_over_random_sets(double decades, double tolerance_of_plan) {
  std::mt19937_64 source(gmis_test::seed(5));
  double worst = 0.0;
  for (const std::size_t n : {1U, 2U, 3U, 7U, 16U, 64U, 256U, 4096U})
    for (int run = 0; run < (n > 256 ? 1 : 40); ++run) {
      // Around one place in the range, or all over it.
      std::uniform_real_distribution<double> place(-decades, decades), spread(0.0, run % 2 == 0 ? 1.0 : 2.0 * decades);
      const double centre = place(source);
      std::vector<Constant<T>> proposals(n);
      std::vector<Wide> exact(n);
      for (std::size_t k = 0; k < n; ++k) {
        proposals[k].value = static_cast<T>(std::pow(10.0, std::clamp(centre + spread(source), -decades, decades)));
        exact[k] = static_cast<Wide>(proposals[k].value);
      }
      worst = std::max(worst, worst_error(proposals, exact, source(), [](T phi) { return static_cast<Wide>(phi); }));
    }
  CAPTURE(worst);
  CHECK(worst < tolerance_of_plan);
  return worst;
}

}  // namespace

TEST_CASE("hostile: denominators of densities from 1e-300 to 1e300, to N = 4096", "[hostile]") {
  worst_over_random_sets<double>(300.0, 1e-13);
}

// To 1e34 only: the sum of 4,096 densities near the end of float's range, 3.4e38, is infinite, and
// then counted.
TEST_CASE("hostile: denominators of float densities", "[hostile]") {
  worst_over_random_sets<float>(34.0, 1e-5);
}

TEST_CASE("hostile: densities given by logarithms as far as 1e±100000", "[hostile]") {
  std::mt19937_64 source(gmis_test::seed(6));
  std::uniform_real_distribution<double> place(-230000.0, 230000.0), spread(0.0, 50.0);
  double worst = 0.0;
  for (int run = 0; run < 200; ++run) {
    const std::size_t n = 1 + static_cast<std::size_t>(run) % 64;
    const double centre = place(source);
    std::vector<LogConstant> proposals(n);
    std::vector<Wide> relative(n);
    for (std::size_t k = 0; k < n; ++k) {
      proposals[k].log_value = centre + spread(source);
      relative[k] = std::exp(static_cast<Wide>(proposals[k].log_value) - static_cast<Wide>(centre));
    }
    // Read relative to the centre; the logarithm itself is rounded to 230000 ε.
    worst = std::max(worst, worst_error(proposals, relative, source(), [&](gmis::LogDensity<double> phi) {
                       return std::exp(static_cast<Wide>(phi.log) - static_cast<Wide>(centre));
                     }));
  }
  CAPTURE(worst);
  CHECK(worst < 2.0 * 230000.0 * 2.3e-16);
}

// A total from which what was drawn is subtracted would lose everything here.
TEST_CASE("hostile: W1 without replacement at N = 4096 does not cancel", "[hostile]") {
  std::vector<Constant<double>> proposals(4096, {1e-250});
  proposals[17].value = 1e250;
  std::vector<Wide> exact;
  for (const auto& q : proposals) exact.push_back(static_cast<Wide>(q.value));
  for (const std::uint64_t seed : {1U, 2U, 3U})
    CHECK(worst_error(proposals, exact, seed, [](double phi) { return static_cast<Wide>(phi); }) < 1e-13);
}

TEST_CASE("hostile: ten million rounds are summed to the last digit", "[hostile]") {
  // f/φ = 0.1 and, once in a million, 1e9: naive sums in double would be off in the seventh place
  // for the small ones.
  const std::vector<Constant<double>> proposals{{1.0}};
  gmis::EstimateAccumulator<double> accumulator;
  const auto set = gmis::as_proposal_set(proposals);
  gmis::Workspace<double, gmis::dynamic_capacity> workspace;
  gmis::Philox source(gmis_test::seed(1));
  std::uint64_t call = 0;
  auto f = [&](int) { return ++call % 1'000'000 == 0 ? 1e9 : 0.1; };
  constexpr std::uint64_t rounds = 10'000'000;
  for (std::uint64_t round = 0; round < rounds; ++round)
    accumulator.add_round(f, 1, [&](auto&& visit) {
      return gmis::sample_round<Scheme::N1>(set, gmis::EqualAllocation{}, source, workspace, visit);
    });
  const Wide expected = (10.0L * 1e9L + (static_cast<Wide>(rounds) - 10.0L) * static_cast<Wide>(0.1)) / rounds;
  CHECK(static_cast<double>(std::abs(static_cast<Wide>(accumulator.result().mean) / expected - 1.0L)) < 1e-13);
}
