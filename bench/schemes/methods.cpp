#include "methods.hpp"

#include <functional>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/methods.hpp"
#include "problems.hpp"
#include "timing.hpp"

namespace bench {
namespace {

using Json = nlohmann::ordered_json;

struct Outcome {
  double mean, density_evaluations;
};
struct Method {
  const char* name;
  std::function<Outcome()> run;  // an estimate of `rounds` rounds
};
constexpr std::uint64_t rounds = 64;
constexpr int repetitions = 200;

Outcome outcome_of(const auto& estimate) {
  return {estimate.mean, static_cast<double>(estimate.density_evaluations)};
}

}  // namespace

Json measured_methods(std::size_t largest, int slices, double slice_seconds, std::uint64_t seed) {
  Json result = Json::array();
  for (const Problem& problem : problems)
    for (const std::size_t n : {std::size_t{4}, std::size_t{16}, std::size_t{64}}) {
      if (n > largest) continue;
      const auto proposals = problem.proposals(n);
      const std::vector<std::uint32_t> ones(n, 1);
      Words source(seed);
      gmis::ScrambledSobol points(seed);
      const gmis::Pilot pilot(problem, proposals, 30, source);
      const gmis::TabulatedProblem& table = pilot.problem();
      const auto coefficients = gmis::control_coefficients(ones, table);
      const auto factors = gmis::variance_aware_factors(table);
      const auto factors_of_balance = gmis::variance_aware_factors_of_balance(ones, table);
      const auto counts = gmis::optimal_counts(table, n);
      const auto groups = gmis::best_groups(table, 4);
      const gmis::Groups<> strided(n, 4);
      const std::vector<std::uint32_t> eight(n, 8);
      const std::vector<Method> methods{
          {"N3", [&] { return outcome_of(gmis::estimate<gmis::Scheme::N3>(problem, proposals, rounds, source)); }},
          {"control variates",
           [&] {
             return outcome_of(gmis::estimate_controlled(problem, proposals, ones, coefficients, rounds, source));
           }},
          {"optimal, progressive",
           [&] { return outcome_of(gmis::estimate_optimal_progressive(problem, proposals, ones, rounds, source)); }},
          {"optimal, direct",
           [&] { return outcome_of(gmis::estimate_optimal_direct(problem, proposals, ones, rounds, source)); }},
          {"variance-aware",
           [&] {
             return outcome_of(
                 gmis::estimate_with_weights(gmis::ScaledBalance{factors}, problem, proposals, ones, rounds, source));
           }},
          {"variance-aware, of balance",
           [&] {
             return outcome_of(gmis::estimate_with_weights(gmis::ScaledBalance{factors_of_balance}, problem, proposals,
                                                           ones, rounds, source));
           }},
          {"allocated counts",
           [&] {
             return outcome_of(gmis::estimate<gmis::Scheme::N3>(
                 problem, proposals, rounds, source, gmis::SampleAllocation(std::vector<std::uint32_t>(counts))));
           }},
          {"pairwise",
           [&] { return outcome_of(gmis::estimate_pairwise(problem, proposals, ones, n / 2, rounds, source)); }},
          {"groups of 4",
           [&] { return outcome_of(gmis::estimate_partial(problem, proposals, strided, rounds, source)); }},
          {"chosen groups of 4",
           [&] { return outcome_of(gmis::estimate_partial(problem, proposals, groups, rounds, source)); }},
          {"resampling, 8 to 1",
           [&] {
             const auto target = [&](double x) { return problem(x) + 1e-3 * proposals[n / 2].pdf(x); };
             return outcome_of(gmis::estimate_resampled(problem, target, proposals, eight, rounds / 8, source));
           }},
          {"scrambled Sobol', 8 rounds of 8",
           [&] {
             points = gmis::ScrambledSobol(source());
             return outcome_of(gmis::estimate_rqmc(problem, proposals, eight, rounds / 8, points));
           }},
      };
      double reference = 0.0;
      for (const Method& method : methods) {
        const double nanoseconds = nanoseconds_of({{method.name,
                                                    [&](long times) {
                                                      double sum = 0.0;
                                                      for (long i = 0; i < times; ++i) sum += method.run().mean;
                                                      return sum;
                                                    }}},
                                                  slices, slice_seconds)[0] /
                                   static_cast<double>(rounds);
        double error = 0.0, bias = 0.0, densities = 0.0;
        for (int i = 0; i < repetitions; ++i) {
          const Outcome outcome = method.run();
          error += (outcome.mean - 1.0) * (outcome.mean - 1.0) / repetitions;
          bias += (outcome.mean - 1.0) / repetitions;
          densities += outcome.density_evaluations / repetitions / static_cast<double>(rounds);
        }
        error *= static_cast<double>(rounds);
        if (reference == 0.0) reference = error * nanoseconds;
        result.push_back({{"problem", problem.name},
                          {"proposals", n},
                          {"method", method.name},
                          {"density_evaluations", densities},
                          {"nanoseconds_per_round", nanoseconds},
                          {"error", error},
                          {"bias", bias},
                          {"efficiency_over_n3", reference / (error * nanoseconds)}});
      }
    }
  return result;
}

}  // namespace bench
