#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>

#include "hostile/weights_oracle.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

// The weights of long paths in float against 200 bits with an unbounded exponent: area densities
// 1e±20, cosines to 1e-8, η from 1e-24 to 1e12, up to 256 edges, deltas of every arrangement. And
// what a recursion in plain float makes of far milder ones.

namespace {

using namespace hostile;

/// Numbers drawn with a generator.
auto drawn_from(std::mt19937_64& source) {
  return [&source](double low, double high) { return std::uniform_real_distribution<double>(low, high)(source); };
}

template <class Heuristic>
void check_paths(const char* name, int paths, bool is_reported) {
  for (const Deltas deltas : {Deltas::none, Deltas::random, Deltas::alternating, Deltas::all}) {
    std::mt19937_64 source(gmis_test::seed(31));
    Tally tally;
    for (int n = 0; n < paths; ++n) {
      const int edges = n % 4 == 0 ? 256 : 2 + static_cast<int>(source() % 255);
      check_path<Heuristic>(hard_path(drawn_from(source), edges, deltas), hard_counts(drawn_from(source)), tally);
    }
    CAPTURE(name, delta_names[static_cast<std::size_t>(deltas)], tally.paths, tally.worst_weight, tally.worst_sum);
    CHECK(tally.paths > 0);
    CHECK(tally.out_of_range == 0);
    CHECK(tally.worst_weight < 1e-5);
    CHECK(tally.worst_sum < 1e-5);
    if (is_reported)
      std::printf("%s, %s: %llu paths, %llu weights, worst relative error %.2g, worst sum 1 ± %.2g\n", name,
                  delta_names[static_cast<std::size_t>(deltas)], static_cast<unsigned long long>(tally.paths),
                  static_cast<unsigned long long>(tally.weights), tally.worst_weight, tally.worst_sum);
  }
}

/// L_i / ρ in plain float, as one would write it down: whether anything in it overflows or becomes
/// NaN.
template <class Heuristic>
bool plain_float_fails(std::mt19937_64& source, int vertices) {
  std::uniform_real_distribution<double> pdf(-4.0, 6.0), cosine(-4.0, 0.0);
  const auto density = [&] {
    const auto per_steradian = static_cast<float>(std::pow(10.0, pdf(source)));
    return Heuristic::of(per_steradian * static_cast<float>(std::pow(10.0, cosine(source))));
  };
  const float eta = Heuristic::of(1e-4F);
  float left = density() / density();
  for (int i = 1; i < vertices; ++i) {
    const float a = density(), b = density();
    left = b * (eta + 1.0F / a + left / a);
    if (!std::isfinite(left)) return true;
  }
  return !std::isfinite(1.0F / (left + 1.0F)) || 1.0F / (left + 1.0F) == 0.0F;
}

template <class Heuristic>
double failure_rate(int vertices, int chains) {
  std::mt19937_64 source(gmis_test::seed(32));
  int failures = 0;
  for (int n = 0; n < chains; ++n) failures += plain_float_fails<Heuristic>(source, vertices) ? 1 : 0;
  return static_cast<double>(failures) / chains;
}

}  // namespace

TEST_CASE("hostile: the running products are those of the brute-force sum", "[hostile]") {
  std::mt19937_64 source(gmis_test::seed(33));
  for (const Deltas deltas : {Deltas::none, Deltas::random, Deltas::alternating, Deltas::all})
    for (const int edges : {2, 3, 5, 40}) {
      const auto path = gmis_test::path_densities<Wide>(hard_path(drawn_from(source), edges, deltas));
      const Counts counts = hard_counts(drawn_from(source));
      const auto brute = gmis::technique_densities(path, counts);
      const auto running = densities_of(path, counts);
      REQUIRE(brute.size() == running.size());
      for (std::size_t i = 0; i < brute.size(); ++i) {
        CHECK(brute[i].technique.is_merge == running[i].technique.is_merge);
        CHECK(brute[i].technique.s == running[i].technique.s);
        CHECK(abs(brute[i].density - running[i].density) <= Wide(1e-50) * brute[i].density);
      }
    }
}

TEST_CASE("hostile: recursive weights of paths of up to 256 edges", "[hostile]") {
  check_paths<gmis::BalanceRatio>("balance", 300, false);
  check_paths<gmis::PowerRatio>("power", 300, false);
}

TEST_CASE("hostile: recursive weights of 160,000 paths of up to 256 edges", "[.][slow]") {
  check_paths<gmis::BalanceRatio>("balance", 20000, true);
  check_paths<gmis::PowerRatio>("power", 20000, true);
}

// Why numbers with an exponent of their own are carried: pdf 1e-4 … 1e6, cosines from 1e-4, nothing
// extreme.
TEST_CASE("hostile: how often a recursion in plain float fails", "[hostile]") {
  const double power_5 = failure_rate<gmis::PowerRatio>(5, 100000),
               power_10 = failure_rate<gmis::PowerRatio>(10, 100000);
  const double balance_10 = failure_rate<gmis::BalanceRatio>(10, 100000);
  std::printf("plain float fails in %.1f %% of power chains of 5, %.1f %% of 10; %.2f %% of balance chains of 10\n",
              100.0 * power_5, 100.0 * power_10, 100.0 * balance_10);
  CHECK(power_5 > 0.02);
  CHECK(power_10 > 0.1);
  CHECK(balance_10 > 0.001);
}
