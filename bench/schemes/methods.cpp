#include "methods.hpp"

#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/methods.hpp"
#include "problems.hpp"

namespace bench {
namespace {

constexpr std::uint64_t rounds = 64;  // of an estimate

gmis::RoundValue value_of_estimate(const auto& estimate) {
  return {estimate.mean, static_cast<double>(estimate.density_evaluations)};
}

}  // namespace

gmis::Comparison compare_methods(const Problem& problem, std::size_t n, const gmis::ComparisonSettings& settings) {
  const auto proposals = problem.proposals(n);
  const std::vector<std::uint32_t> ones(n, 1);
  Words pilot_source(settings.seed);
  gmis::ScrambledSobol points(settings.seed);
  const gmis::PilotSamples pilot(problem, proposals, 30, pilot_source);
  const gmis::TabulatedProblem& table = pilot.problem();
  const auto coefficients = gmis::control_coefficients(ones, table);
  const auto factors = gmis::variance_aware_factors(table);
  const auto factors_of_balance = gmis::variance_aware_factors_of_balance(ones, table);
  const auto counts = gmis::optimal_counts(table, n);
  const auto groups = gmis::best_groups(table, 4);
  const gmis::Groups<> strided(n, 4);
  const std::vector<std::uint32_t> eight(n, 8);
  const std::vector<gmis::Contender> methods{
      {"N3",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate<gmis::Scheme::N3>(problem, proposals, rounds, source));
       }},
      {"control variates",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_controlled(problem, proposals, ones, coefficients, rounds, source));
       }},
      {"optimal, progressive",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_optimal_progressive(problem, proposals, ones, rounds, source));
       }},
      {"optimal, direct",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_optimal_direct(problem, proposals, ones, rounds, source));
       }},
      {"variance-aware",
       [&](Words& source) {
         return value_of_estimate(
             gmis::estimate_with_weights(gmis::ScaledBalance{factors}, problem, proposals, ones, rounds, source));
       }},
      {"variance-aware, of balance",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_with_weights(gmis::ScaledBalance{factors_of_balance}, problem,
                                                              proposals, ones, rounds, source));
       }},
      {"allocated counts",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate<gmis::Scheme::N3>(
             problem, proposals, rounds, source, gmis::SampleAllocation(std::vector<std::uint32_t>(counts))));
       }},
      {"pairwise",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_pairwise(problem, proposals, ones, n / 2, rounds, source));
       }},
      {"groups of 4",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_partial(problem, proposals, strided, rounds, source));
       }},
      {"chosen groups of 4",
       [&](Words& source) {
         return value_of_estimate(gmis::estimate_partial(problem, proposals, groups, rounds, source));
       }},
      {"resampling, 8 to 1",
       [&](Words& source) {
         const auto target = [&](double x) { return problem(x) + 1e-3 * proposals[n / 2].pdf(x); };
         return value_of_estimate(gmis::estimate_resampled(problem, target, proposals, eight, rounds / 8, source));
       }},
      {"scrambled Sobol', 8 rounds of 8",
       [&](Words& source) {
         points = gmis::ScrambledSobol(source());
         return value_of_estimate(gmis::estimate_rqmc(problem, proposals, eight, rounds / 8, points));
       }},
  };
  auto measured = settings;
  measured.measure_seconds = 1e-9;  // 400 estimates
  return gmis::compare(problem.name + std::string(", methods, N = ") + std::to_string(n), 1.0, methods, measured);
}

}  // namespace bench
