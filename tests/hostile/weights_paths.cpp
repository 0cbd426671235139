#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/synthetic_path.hpp"

// The weights of long paths in float against 200 bits with an unbounded exponent: area densities 1e±20, cosines to 1e-8, η
// from 1e-24 to 1e12, up to 256 edges, deltas of every arrangement. And what a recursion in plain float makes of far milder
// ones.

namespace {

using Wide = boost::multiprecision::number<
    boost::multiprecision::cpp_bin_float<200, boost::multiprecision::digit_base_2, void, std::int64_t>>;
using Counts = gmis::TechniqueCounts<float>;
using Path = gmis_test::SyntheticPath<float>;

enum class Deltas { none, random, alternating, all };
constexpr std::array<const char*, 4> delta_names{"no delta vertices", "random delta vertices", "alternating with delta",
                                                 "delta vertices alone"};

/// Densities per area log-uniform in 1e±20, made of cosines in [1e-8, 1], squared distances in 1e±4 and what is left.
Path hard_path(std::mt19937_64& source, int edges, Deltas deltas) {
  std::uniform_real_distribution<double> area(-20.0, 20.0), cosine(-8.0, 0.0), distance(-4.0, 4.0), unit(0.0, 1.0);
  const auto power = [](double exponent) { return static_cast<float>(std::pow(10.0, exponent)); };
  const auto n = static_cast<std::size_t>(edges) + 1;
  Path path;
  path.forward.resize(n);
  path.reverse.resize(n);
  path.to_area_from_light.resize(n);
  path.to_area_from_camera.resize(n);
  path.is_delta.resize(n);
  std::vector<double> squared(n);  // of edge i → i + 1
  for (double& d : squared) d = distance(source);
  for (std::size_t i = 0; i < n; ++i) {
    path.to_area_from_light[i] = power(cosine(source) - squared[i > 0 ? i - 1 : 0]);
    path.to_area_from_camera[i] = power(cosine(source) - squared[i]);
    const bool is_inside = i > 0 && i + 1 < n;
    path.is_delta[i] = is_inside && (deltas == Deltas::all || (deltas == Deltas::alternating && i % 2 == 0) ||
                                     (deltas == Deltas::random && unit(source) < 0.5));
  }
  for (std::size_t i = 0; i < n; ++i) {
    // Towards x_{i+1} and back to x_{i-1}: the density per steradian that makes the one per area.
    path.forward[i] =
        power(area(source) - std::log10(static_cast<double>(path.to_area_from_light[std::min(i + 1, n - 1)])));
    path.reverse[i] =
        power(area(source) - std::log10(static_cast<double>(path.to_area_from_camera[i > 0 ? i - 1 : 0])));
  }
  path.origin = power(area(source));
  path.first = power(area(source) - std::log10(static_cast<double>(path.to_area_from_light[1])));
  path.camera = power(area(source) - std::log10(static_cast<double>(path.to_area_from_camera[n - 2])));
  path.next_event = unit(source) < 0.3 ? path.origin : power(area(source));
  path.light_can_be_hit = unit(source) < 0.7 || deltas == Deltas::all;
  return path;
}

Counts hard_counts(std::mt19937_64& source) {
  std::uniform_real_distribution<double> eta(-24.0, 12.0), splats(0.0, 6.0);
  return {1.0F, 1.0F, 1.0F, static_cast<float>(std::pow(10.0, splats(source))),
          static_cast<float>(std::pow(10.0, eta(source)))};
}

/// The densities of all techniques, as `technique_densities` has them but with running products from both ends.
std::vector<gmis::TechniqueDensity<Wide>> densities_of(const gmis::PathDensities<Wide>& path, const Counts& counts) {
  const std::size_t k = path.from_light.size();
  std::vector<Wide> light(k + 1, Wide(1)), camera(k + 1, Wide(1));
  for (std::size_t i = 0; i < k; ++i) light[i + 1] = light[i] * path.from_light[i];
  for (std::size_t i = k; i-- > 0;) camera[i] = camera[i + 1] * path.from_camera[i];
  const auto joins = [&](std::size_t i) { return i == 0 || i == k || !path.is_delta[i]; };

  std::vector<gmis::TechniqueDensity<Wide>> all;
  for (std::size_t s = 0; s <= k; ++s) {
    Wide density(0);
    if (s == 0 && path.light_can_be_hit) density = Wide(counts.emitter_hit) * camera[0];
    if (s == 1 && joins(1)) density = Wide(counts.next_event) * path.next_event * camera[1];
    if (s >= 2 && s == k && joins(k - 1)) density = Wide(counts.splat) * light[k];
    if (s >= 2 && s < k && joins(s - 1) && joins(s)) density = Wide(counts.connect) * light[s] * camera[s];
    all.push_back({{false, static_cast<int>(s)}, density});
  }
  for (std::size_t i = 1; i < k; ++i)
    all.push_back(
        {{true, static_cast<int>(i)}, joins(i) ? Wide(Wide(counts.merge) * light[i + 1] * camera[i]) : Wide(0)});
  return all;
}

struct Tally {
  std::uint64_t paths = 0;
  std::uint64_t weights = 0;
  std::uint64_t out_of_range = 0;  ///< not a number, or not in [0, 1]
  double worst_weight = 0.0;       ///< relative error, of weights above 1e-30; absolute of others
  double worst_sum = 0.0;
};

template <class Heuristic>
void check_path(const Path& path, const Counts& counts, Tally& tally) {
  const gmis_test::RecursiveWeights<float, Heuristic> recursion(path, counts);
  auto densities = densities_of(gmis_test::path_densities<Wide>(path), counts);
  Wide total = 0;
  for (auto& technique : densities) total += technique.density = Heuristic::of(technique.density);
  if (total == 0) return;  // nothing can make this path
  ++tally.paths;
  double sum = 0.0;
  for (const auto& technique : densities) {
    if (technique.density == 0) continue;
    const float weight = recursion.weight(technique.technique);
    ++tally.weights;
    if (!(weight >= 0.0F && weight <= 1.0F)) {
      ++tally.out_of_range;
      continue;
    }
    sum += static_cast<double>(weight);
    const auto expected = static_cast<double>(Wide(technique.density / total));
    const double error = std::abs(static_cast<double>(weight) - expected);
    tally.worst_weight = std::max(tally.worst_weight, expected > 1e-30 ? error / expected : error);
  }
  tally.worst_sum = std::max(tally.worst_sum, std::abs(sum - 1.0));
}

template <class Heuristic>
void check_paths(const char* name, int paths, bool is_reported) {
  for (const Deltas deltas : {Deltas::none, Deltas::random, Deltas::alternating, Deltas::all}) {
    std::mt19937_64 source(gmis_test::seed(31));
    Tally tally;
    for (int n = 0; n < paths; ++n) {
      const int edges = n % 4 == 0 ? 256 : 2 + static_cast<int>(source() % 255);
      check_path<Heuristic>(hard_path(source, edges, deltas), hard_counts(source), tally);
    }
    CAPTURE(name, delta_names[static_cast<std::size_t>(deltas)], tally.paths, tally.worst_weight, tally.worst_sum);
    CHECK(tally.paths > 0);
    CHECK(tally.out_of_range == 0);
    CHECK(tally.worst_weight < 2e-5);
    CHECK(tally.worst_sum < 1e-5);
    if (is_reported)
      std::printf("%s, %s: %llu paths, %llu weights, worst relative error %.2g, worst sum 1 ± %.2g\n", name,
                  delta_names[static_cast<std::size_t>(deltas)], static_cast<unsigned long long>(tally.paths),
                  static_cast<unsigned long long>(tally.weights), tally.worst_weight, tally.worst_sum);
  }
}

/// L_i / ρ in plain float, as one would write it down: whether anything in it overflows or becomes NaN.
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
      const auto path = gmis_test::path_densities<Wide>(hard_path(source, edges, deltas));
      const Counts counts = hard_counts(source);
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

// Why numbers with an exponent of their own are carried: pdf 1e-4 … 1e6, cosines from 1e-4, nothing extreme.
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
