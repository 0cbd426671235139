#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/synthetic_path.hpp"

// The recursion against the brute-force sum over all techniques, in long double, for invented
// paths.

namespace {

using Wide = long double;

struct Worst {
  double weight = 0.0;  ///< relative error of a weight
  double sum = 0.0;     ///< deviation of the sum of the weights of one path from 1
};

/// The larger error; one that is not a number is the largest.
double worse(double worst, Wide error) {
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, static_cast<double>(error));
}

template <class T>
gmis::TechniqueCounts<T> random_counts(std::mt19937_64& source) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto log_uniform = [&](double low, double high) {
    return static_cast<T>(std::pow(10.0, low + (high - low) * unit(source)));
  };
  const auto off_sometimes = [&](T count) { return unit(source) < 0.15 ? T(0) : count; };
  gmis::TechniqueCounts<T> counts;
  counts.emitter_hit = T(1);
  counts.next_event = off_sometimes(T(1));
  counts.connect = off_sometimes(unit(source) < 0.5 ? T(1) : log_uniform(-1.0, 1.0));
  counts.splat = off_sometimes(log_uniform(0.0, 6.0));
  counts.merge = off_sometimes(log_uniform(-6.0, 4.0));
  return counts;
}

template <class T, class Heuristic>
Worst worst_error(int paths, double decades, std::uint64_t seed, bool chooses_for_receiver) {
  std::mt19937_64 source(gmis_test::seed(seed));
  Worst worst;
  for (int n = 0; n < paths; ++n) {
    const int edges = 1 + n % 12;
    const auto path = gmis_test::random_path<T>(source, edges, decades, 0.25, 0.6, chooses_for_receiver);
    const auto counts = random_counts<T>(source);
    const gmis_test::RecursiveWeights<T, Heuristic> recursion(path, counts);

    const auto densities = gmis::technique_densities(gmis_test::path_densities<Wide>(path), counts);
    Wide total = 0;
    for (const auto& technique : densities) total += Heuristic::of(technique.density);
    if (total == 0) continue;  // every technique that could make this path is off
    Wide sum = 0;
    for (const auto& technique : densities) {
      if (technique.density == 0) continue;
      const Wide expected = Heuristic::of(technique.density) / total;
      const Wide weight = static_cast<Wide>(recursion.weight(technique.technique));
      sum += weight;
      // A weight too small for T may become 0: then the absolute error counts.
      if (expected > static_cast<Wide>(std::numeric_limits<T>::min()) * 1000)
        worst.weight = worse(worst.weight, std::abs(weight / expected - 1));
      else
        worst.weight = worse(worst.weight, std::abs(weight - expected));
    }
    worst.sum = worse(worst.sum, std::abs(sum - 1));
  }
  return worst;
}

template <class T, class Heuristic>
void check_all(double decades, double tolerance) {
  for (const bool chooses_for_receiver : {false, true}) {
    const Worst worst = worst_error<T, Heuristic>(10000, decades, 1, chooses_for_receiver);
    CAPTURE(decades, chooses_for_receiver, worst.weight, worst.sum);
    CHECK(worst.weight < tolerance);
    CHECK(worst.sum < tolerance);
  }
}

}  // namespace

TEST_CASE("the recursive weights equal the sum over all techniques, and sum to one") {
  for (const double decades : {1.0, 4.0, 9.0}) {
    SECTION("float, balance, 10^±" + std::to_string(decades)) {
      check_all<float, gmis::BalanceRatio>(decades, 1e-5);
    }
    SECTION("float, power, 10^±" + std::to_string(decades)) {
      check_all<float, gmis::PowerRatio>(decades, 1e-5);
    }
    SECTION("double, balance, 10^±" + std::to_string(decades)) {
      check_all<double, gmis::BalanceRatio>(decades, 1e-12);
    }
    SECTION("double, power, 10^±" + std::to_string(decades)) {
      check_all<double, gmis::PowerRatio>(decades, 1e-12);
    }
  }
}
