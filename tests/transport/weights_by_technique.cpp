#include "gmis/transport/weights/weights_by_technique.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "gmis/transport/allocation/forecast.hpp"
#include "gmis/transport/state/integrators.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"
#include "transport/synthetic_path.hpp"

// Sums by technique: from one run of the recursion, the weights under any other counts, against the
// brute-force sum over all techniques with those counts in long double.

namespace {

using Wide = long double;

/// The technique of an index, on a path of k edges.
gmis::Technique technique_of(const gmis::TechniqueIndex& index, int k) {
  if (index.is_merge) return gmis::Technique::merge;
  if (index.s == 0) return gmis::Technique::emitter_hit;
  if (index.s == 1) return gmis::Technique::next_event;
  return index.s == k ? gmis::Technique::splat : gmis::Technique::connect;
}

template <class T>
gmis::TechniqueCounts<T> scaled(gmis::TechniqueCounts<T> counts, const gmis::PerTechnique<T>& factors) {
  const auto factor = [&](gmis::Technique t) { return factors[static_cast<std::size_t>(t)]; };
  counts.emitter_hit *= factor(gmis::Technique::emitter_hit);
  counts.next_event *= factor(gmis::Technique::next_event);
  counts.connect *= factor(gmis::Technique::connect);
  counts.splat *= factor(gmis::Technique::splat);
  counts.merge *= factor(gmis::Technique::merge);
  return counts;
}

template <class T>
double worst_error(int paths, std::uint64_t seed) {
  std::mt19937_64 source(gmis_test::seed(seed));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto log_uniform = [&](double low, double high) {
    return static_cast<T>(std::pow(10.0, low + (high - low) * unit(source)));
  };
  double worst = 0.0;
  for (int n = 0; n < paths; ++n) {
    const int edges = 1 + n % 10;
    const auto path = gmis_test::random_path<T>(source, edges, 1.5, 0.25, 0.6);
    const gmis::TechniqueCounts<T> counts{T(1), T(1), log_uniform(-1.0, 1.0), log_uniform(0.0, 4.0),
                                          log_uniform(-3.0, 3.0)};
    gmis::PerTechnique<T> factors{T(1), T(1), T(0), T(0), T(0)};
    for (std::size_t g = 2; g < factors.size(); ++g)
      if (unit(source) > 0.25) factors[g] = log_uniform(-1.0, 1.0);
    const gmis_test::RecursiveWeights<T, gmis::BalanceRatio, gmis::SeparateSums<T>> recursion(path, counts);

    const auto made = gmis::technique_densities(gmis_test::path_densities<Wide>(path), counts);
    const auto wanted = gmis::technique_densities(gmis_test::path_densities<Wide>(path), scaled(counts, factors));
    Wide total = 0;
    for (const auto& technique : wanted) total += technique.density;
    for (std::size_t i = 0; i < made.size(); ++i) {
      if (made[i].density == 0) continue;  // it never makes this path, so no weight is asked for
      const gmis::TechniqueDensities<T> densities = recursion.weight(made[i].technique);
      REQUIRE(densities.own == technique_of(made[i].technique, edges));
      T sum(0);
      for (std::size_t g = 0; g < factors.size(); ++g)
        if (factors[g] > T(0)) sum += factors[g] * densities.relative[g];  // 0 times infinity is not meant
      if (total == 0) {
        REQUIRE(sum == T(0));
        continue;
      }
      // All densities over this technique's own, before its count was changed.
      const Wide expected = total / made[i].density;
      const Wide error = std::abs(static_cast<Wide>(sum) / expected - 1);
      REQUIRE_FALSE(std::isnan(error));  // a maximum would not show it
      worst = std::max(worst, static_cast<double>(error));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("Sums by technique give the weights under any counts", "[weights][pilot]") {
  CHECK(worst_error<double>(20000, 41) < 1e-12);
  CHECK(worst_error<float>(20000, 42) < 1e-5);
}

TEST_CASE("A path whose own technique has no density has none relative to it", "[weights]") {
  using Sums = gmis::SeparateSums<float>;
  const auto relative = [](auto zero, auto one) {
    const auto own = Sums::of<gmis::Technique::merge>(zero);
    return Sums::weight({own, Sums::of<gmis::Technique::splat>(one)}).relative;
  };
  CHECK(relative(0.0, 1.0) == gmis::PerTechnique<float>{});
  CHECK(relative(gmis::Extended<float>(0.0F), gmis::Extended<float>(1.0F)) == gmis::PerTechnique<float>{});
}

TEST_CASE("The factors of a candidate are its counts over those that were made", "[pilot]") {
  const gmis::SampleCounts made{1.0, 2, true, true};
  using Factors = gmis::PerTechnique<double>;
  CHECK(gmis::count_factors<double>(made, made) == Factors{1, 1, 1, 1, 1});
  CHECK(gmis::count_factors<double>({0.25, 4, true, false}, made) == Factors{1, 1, 2, 0.25, 0});
  CHECK(gmis::count_factors<double>({2.0, 0, true, true}, made) == Factors{1, 1, 0, 2, 2});
  CHECK(gmis::count_factors<double>({0.0, 0, false, false}, made) == Factors{1, 1, 0, 0, 0});
  gmis::SampleCounts wide = made;
  wide.radius_factor = 3;
  CHECK(gmis::count_factors<double>(wide, made) == Factors{1, 1, 1, 1, 9});
}

TEST_CASE("The disk that is merged in, in the mean over a run", "[pilot]") {
  const auto brute_force = [](double alpha, std::uint32_t iterations) {
    long double sum = 0;
    for (std::uint32_t i = 1; i <= iterations; ++i) sum += std::pow(static_cast<long double>(i), alpha - 1.0L);
    return static_cast<double>(sum / iterations);
  };
  for (const double alpha : {0.3, 2.0 / 3.0, 1.0})
    for (const std::uint32_t iterations : {1U, 2U, 64U, 65U, 1000U, 100000U}) {
      INFO("alpha " << alpha << ", " << iterations << " iterations");
      CHECK(std::abs(gmis::mean_disk(alpha, iterations) / brute_force(alpha, iterations) - 1.0) < 1e-5);
    }
  CHECK(gmis::mean_disk(0.5, 0) == 1.0);
}

TEST_CASE("What a candidate costs follows from the work of the pilot, part by part", "[pilot]") {
  const gmis::Counters light_work{.rays = 1000, .shadow_rays = 500, .projections = 900, .photons_stored = 800};
  const gmis::Counters work{.rays = 2000,
                            .shadow_rays = 3000,
                            .connections = 4000,
                            .connection_rays = 1200,
                            .merge_queries = 1500,
                            .merges = 6000};
  const gmis::OperationCosts costs{1.0, 0.5, 0.25, 2.0, 0.125, 4.0, 8.0};
  const gmis::SampleCounts made{1.0, 2, true, true};
  const auto light = [&](const gmis::SampleCounts& c) {
    return gmis::predicted_light_cost(c, made, light_work, light_work.photons_stored, costs);
  };
  const auto camera = [&](const gmis::SampleCounts& c) { return gmis::predicted_camera_cost(c, made, work, costs); };
  CHECK(light({0.0, 0, false, false}) == 0);
  CHECK(light(made) == 1000 + 0.5 * 500 + 4.0 * 800 + 8.0 * 900);
  CHECK(light({0.5, 1, true, false}) == 0.5 * (1000 + 0.5 * 500 + 4.0 * 800 + 8.0 * 900));
  CHECK(light({2.0, 0, true, false}) == 2 * (1000 + 0.5 * 500 + 8.0 * 900));
  CHECK(light({0.5, 1, false, false}) == 0.5 * (1000 + 4.0 * 800));
  // Merging alone keeps the photons alone, of which a local count has fewer.
  CHECK(gmis::predicted_light_cost({0.5, 0, true, true}, made, light_work, 300, costs) ==
        0.5 * (1000 + 0.5 * 500 + 4.0 * 300 + 8.0 * 900));
  CHECK(camera({0.0, 0, false, false}) == 2000 + 0.5 * 1800);
  CHECK(camera(made) == 2000 + 0.5 * 1800 + 0.25 * 4000 + 0.5 * 1200 + 2.0 * 1500 + 0.125 * 6000);
  CHECK(camera({0.5, 1, true, false}) == 2000 + 0.5 * 1800 + 0.5 * (0.25 * 4000 + 0.5 * 1200));
  CHECK(camera({2.0, 0, true, true}) == 2000 + 0.5 * 1800 + 2.0 * 1500 + 2 * 0.125 * 6000);
  gmis::SampleCounts wide = made;
  wide.radius_factor = 3;
  CHECK(camera(wide) == camera(made) + 8 * 0.125 * 6000);
}

TEST_CASE("The best candidate has the least work of those that miss no light", "[pilot]") {
  const auto forecast = [](double variance, double squared_bias, double cost, double missing) {
    return gmis::Forecast{{1.0, 1, true, false}, variance, squared_bias, cost, missing};
  };
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), forecast(2, 0, 4, 0), forecast(0.5, 0, 30, 0)}, 64) == 1);
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), forecast(2, 0, 4, 0.01)}, 64) == 0);
  CHECK(gmis::best_of({forecast(2, 0, 4, 0.01), forecast(1, 0, 10, 0)}, 64) == 1);
  CHECK(gmis::best_of({forecast(1, 0, 10, 0.3), forecast(2, 0, 40, 0.2)}, 64) == 1);
  // A bias does not fall with the iterations.
  CHECK(gmis::best_of({forecast(1, 0.01, 10, 0), forecast(1.2, 0, 10, 0)}, 4) == 0);
  CHECK(gmis::best_of({forecast(1, 0.01, 10, 0), forecast(1.2, 0, 10, 0)}, 64) == 1);
  // No merging must gain more than an eighth, where there is merging.
  gmis::Forecast merges = forecast(1, 0, 10, 0);
  merges.counts.merges = true;
  CHECK(gmis::best_of({merges, forecast(0.88, 0, 10, 0)}, 64) == 0);
  CHECK(gmis::best_of({merges, forecast(0.86, 0, 10, 0)}, 64) == 1);
  // Light trees for splats alone must gain another quarter; a plan without light trees need not.
  gmis::Forecast splats = forecast(0.76, 0, 10, 0);
  splats.counts.connections = 0;
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), splats}, 64) == 0);
  splats.variance = 0.74;
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), splats}, 64) == 1);
  gmis::Forecast one_side = forecast(0.76, 0, 10, 0);
  one_side.counts = {0.0, 0, false, false};
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), one_side}, 64) == 1);
  splats.counts.merges = true;
  splats.variance = 0.9;
  CHECK(gmis::best_of({forecast(1, 0, 10, 0), splats}, 64) == 1);
}

TEST_CASE("Every candidate has its place, and none on the light side when nothing is traced there", "[pilot]") {
  const auto all = gmis::all_candidates();
  CHECK(all.size() == 1 + 4 * 3 * 2);
  for (const auto& candidate : all)
    if (!candidate.traces_light()) CHECK((candidate.connections == 0 && !candidate.splats && !candidate.merges));
  // What is off in all is off in each.
  for (const auto& candidate : gmis::all_candidates(gmis::integrators::bpt)) CHECK_FALSE(candidate.merges);
  CHECK(gmis::all_candidates(gmis::integrators::pt) == std::vector<gmis::SampleCounts>{gmis::integrators::pt});
  gmis::CountChoices few;
  few.light_paths = {1.0};
  few.connections = {2};
  few.merges = {true};
  CHECK(gmis::all_candidates({}, few) == std::vector<gmis::SampleCounts>{{1.0, 2, true, true}});
  // Each radius for those that merge; the rest do not differ by it.
  few.merges = {false, true};
  few.radius_factors = {2.0, 8.0};
  gmis::SampleCounts local;
  local.local_merges = true;
  CHECK(gmis::all_candidates(local, few) ==
        std::vector<gmis::SampleCounts>{{1.0, 2, true, false, 1},
                                        {1.0, 2, true, true, true, true, true, true, 2.0},
                                        {1.0, 2, true, true, true, true, true, true, 8.0}});
}
