#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "four_problems.hpp"
#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics/best_scheme.hpp"
#include "gmis/mis/methods/adaptive_mis.hpp"
#include "gmis/mis/methods/best_groups.hpp"
#include "gmis/mis/methods/compensation.hpp"
#include "gmis/mis/methods/optimal_allocation.hpp"
#include "gmis/mis/methods/optimal_weights.hpp"
#include "gmis/mis/methods/pairwise.hpp"
#include "gmis/mis/methods/population.hpp"
#include "gmis/mis/methods/randomised_qmc.hpp"
#include "gmis/mis/methods/resampling.hpp"
#include "gmis/mis/methods/stochastic_mis.hpp"
#include "gmis/mis/methods/variance_aware.hpp"

/// Every method of docs/mis-methods.md as one call on one of the four problems, with about `budget`
/// evaluations of f, those of a pilot included.
namespace methods {

struct Outcome {
  double mean;
  double integrand_evaluations;
  double density_evaluations;
};
struct Method {
  const char* name;
  std::function<Outcome(const four::Problem&, std::uint32_t budget, gmis::Philox&)> run;
};

inline Outcome outcome_of(const auto& estimate) {
  return {estimate.mean, static_cast<double>(estimate.integrand_evaluations),
          static_cast<double>(estimate.density_evaluations)};
}

/// Runs `rest(pilot, rounds)` after a pilot of a tenth of the budget, and adds what the pilot cost.
inline Outcome with_pilot(const four::Problem& problem, std::uint32_t budget, gmis::Philox& source, auto rest) {
  const auto n = static_cast<std::uint32_t>(problem.proposals.size());
  const std::uint32_t pilot_rounds = budget / 10 / n;
  const gmis::PilotSamples pilot(problem.f, problem.proposals, pilot_rounds, source);
  Outcome outcome = outcome_of(rest(pilot.problem(), budget / n - pilot_rounds));
  outcome.integrand_evaluations += pilot_rounds * n;
  outcome.density_evaluations += pilot_rounds * n * n;
  return outcome;
}

/// A density that is constant in each of equal cells, from their probabilities.
struct Cells {
  double low, width;
  std::vector<double> probabilities, cumulative;
  Cells(double from, double cell_width, std::vector<double> p)
      : low(from), width(cell_width), probabilities(std::move(p)) {
    double sum = 0.0;
    for (const double probability : probabilities) cumulative.push_back(sum += probability);
  }
  double sample(gmis::UniformSource auto& source) const {
    const double u = gmis::uniform<double>(source) * cumulative.back();
    const auto cell = std::upper_bound(cumulative.begin(), cumulative.end(), u) - cumulative.begin();
    return low + width * (static_cast<double>(cell) + gmis::uniform<double>(source));
  }
  double pdf(double x) const {
    const double cell = (x - low) / width;
    return cell >= 0.0 && cell < static_cast<double>(probabilities.size())
               ? probabilities[static_cast<std::size_t>(cell)] / width
               : 0.0;
  }
};

/// A table of |f| in 24 cells beside the broadest proposal, compensated or not.
inline Outcome with_table(const four::Problem& problem, std::uint32_t budget, gmis::Philox& source, bool compensate) {
  constexpr std::size_t cells = 24;
  const bool is_line = problem.breakpoints.front() < 0.0;
  const double low = is_line ? -6.0 : 0.0, width = (is_line ? 12.0 : 1.0) / cells;
  const four::Density broad = is_line ? four::logistic(0.0, 2.0) : four::uniform(0.0, 1.0);
  std::vector<double> target(cells), others(cells);
  double sum = 0.0;
  for (std::size_t i = 0; i < cells; ++i) {
    const double x = low + width * (static_cast<double>(i) + 0.5);
    sum += target[i] = std::abs(problem.f(x)) * width;
    others[i] = broad.pdf(x) * width;
  }
  std::vector<double> table = target;
  for (double& p : table) p /= sum;
  if (compensate) table = gmis::compensated_density(target, others, 0.5);
  const auto proposals = std::make_tuple(Cells(low, width, table), broad);
  return outcome_of(gmis::estimate<gmis::Scheme::N3>(problem.f, proposals, budget / 2, source));
}

/// A finite family for stochastic MIS: densities that all cover f.
struct Family {
  std::vector<four::Density> densities;
  std::size_t draw(gmis::UniformSource auto& source) const {
    return gmis::uniform_index(source, static_cast<std::uint32_t>(densities.size()));
  }
  double sample(std::size_t k, gmis::UniformSource auto& source) const { return densities[k].sample(source); }
  double pdf(std::size_t k, double x) const { return densities[k].pdf(x); }
  double marginal_pdf(double x) const {
    double sum = 0.0;
    for (const auto& density : densities) sum += density.pdf(x);
    return sum / static_cast<double>(densities.size());
  }
};
inline Family family_of(const four::Problem& problem) {
  Family family;
  for (int k = 0; k < 9; ++k)
    family.densities.push_back(problem.breakpoints.front() < 0.0 ? four::logistic(k - 4.0, 1.2)
                                                                 : four::ramp(0.45 * (k - 4.0)));
  return family;
}

inline std::vector<Method> all() {
  using gmis::Scheme;
  using Counts = std::vector<std::uint32_t>;
  const auto plain = [](Scheme scheme) {
    return [scheme](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
      return outcome_of(gmis::estimate(scheme, p.f, p.proposals, budget / p.proposals.size(), source));
    };
  };
  const auto in_rounds = [](auto call) {
    return [call](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
      return outcome_of(call(p, p.one_each(), budget / p.proposals.size(), source));
    };
  };
  const auto piloted = [](auto call) {
    return [call](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
      return with_pilot(p, budget, source, [&](const gmis::TabulatedProblem& pilot, std::uint64_t rounds) {
        return call(p, pilot, p.one_each(), rounds, source);
      });
    };
  };
  return {
      {"N3", plain(Scheme::N3)},
      {"R3", plain(Scheme::R3)},
      {"N1", plain(Scheme::N1)},
      {"power 2", in_rounds([](const auto& p, const Counts& counts, std::uint64_t rounds, auto& source) {
         return gmis::estimate_with_weights(gmis::RatioWeights<gmis::Power>{{2.0}}, p.f, p.proposals, counts, rounds,
                                            source);
       })},
      {"variance-aware", piloted([](const auto& p, const auto& pilot, const Counts& counts, auto rounds, auto& source) {
         const auto factors = gmis::variance_aware_factors(pilot);
         return gmis::estimate_with_weights(gmis::ScaledBalance{factors}, p.f, p.proposals, counts, rounds, source);
       })},
      {"variance-aware, of balance",
       piloted([](const auto& p, const auto& pilot, const Counts& counts, auto rounds, auto& source) {
         const auto factors = gmis::variance_aware_factors_of_balance(counts, pilot);
         return gmis::estimate_with_weights(gmis::ScaledBalance{factors}, p.f, p.proposals, counts, rounds, source);
       })},
      {"pairwise", in_rounds([](const auto& p, const Counts& counts, std::uint64_t rounds, auto& source) {
         const std::size_t canonical = p.f == four::span ? 2 : p.f == four::waves ? 5 : 0;  // the broadest
         return gmis::estimate_pairwise(p.f, p.proposals, counts, canonical, rounds, source);
       })},
      {"chosen pairs", piloted([](const auto& p, const auto& pilot, const Counts&, auto rounds, auto& source) {
         const std::size_t size = p.f == four::highlight ? 4 : p.f == four::waves ? 3 : 2;  // pairs leave holes there
         return gmis::estimate_partial(p.f, p.proposals, gmis::best_groups(pilot, size), rounds, source);
       })},
      {"control variates",
       piloted([](const auto& p, const auto& pilot, const Counts& counts, auto rounds, auto& source) {
         return gmis::estimate_controlled(p.f, p.proposals, counts, gmis::control_coefficients(counts, pilot), rounds,
                                          source);
       })},
      {"optimal, direct", in_rounds([](const auto& p, const Counts& counts, std::uint64_t rounds, auto& source) {
         return gmis::estimate_optimal_direct(p.f, p.proposals, counts, rounds, source);
       })},
      {"optimal, progressive", in_rounds([](const auto& p, const Counts& counts, std::uint64_t rounds, auto& source) {
         return gmis::estimate_optimal_progressive(p.f, p.proposals, counts, rounds, source);
       })},
      {"allocated counts",
       piloted([](const auto& p, const auto& pilot, const Counts& counts, auto rounds, auto& source) {
         const auto chosen = gmis::optimal_counts(pilot, 4 * counts.size());
         const gmis::SampleAllocation<double> allocation{std::span<const std::uint32_t>(chosen)};
         return gmis::estimate<Scheme::N3>(p.f, p.proposals, rounds / 4, source, allocation);
       })},
      {"counts and controls",
       piloted([](const auto& p, const auto& pilot, const Counts& counts, auto rounds, auto& source) {
         const auto chosen = gmis::optimal_counts(pilot, 4 * counts.size());
         return gmis::estimate_controlled(p.f, p.proposals, chosen, gmis::control_coefficients(chosen, pilot),
                                          rounds / 4, source);
       })},
      {"scrambled Sobol'",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         gmis::ScrambledSobol points((std::uint64_t{source()} << 32U) | source());
         const Counts counts(p.proposals.size(), 32);
         return outcome_of(gmis::estimate_rqmc(p.f, p.proposals, counts, budget / 32 / counts.size(), points));
       }},
      {"resampling, 4 rounds to 1",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         const bool is_line = p.breakpoints.front() < 0.0;
         const auto target = [&](double x) {  // a rough picture of |f|
           return is_line ? 0.1 * four::logistic(0.0, 1.5).pdf(x) + four::normal(x, -3.0, 1.0) +
                                2.0 * four::normal(x, 0.0, 1.0) + four::normal(x, 3.0, 1.0)
                          : 0.2 + std::abs(p.f(x)) * (1.0 + 0.3 * std::sin(20.0 * x));
         };
         return outcome_of(
             gmis::estimate_resampled(p.f, target, p.proposals, Counts(p.proposals.size(), 4), budget, source));
       }},
      {"population",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         const bool is_line = p.breakpoints.front() < 0.0;
         std::vector<four::Density> population;
         for (int k = 0; k < 8; ++k)
           population.push_back(is_line ? four::logistic(-6.0 + 1.7 * k, 0.8) : four::logistic(0.12 * k + 0.08, 0.1));
         const auto f = [&](double x) { return is_line || (x >= 0.0 && x < 1.0) ? p.f(x) : 0.0; };
         const auto move = [](const four::Density& q, double x) { return four::logistic(x, q.b); };
         return outcome_of(gmis::estimate_population(f, population, 8, budget / 64, move, source));
       }},
      {"adaptive",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         const bool is_line = p.breakpoints.front() < 0.0;
         const four::Density first = is_line ? four::logistic(1.0, 2.0) : four::uniform(0.0, 1.0);
         const auto fit = [&](std::span<const double> x, std::span<const double> w) {
           double sum = 1e-300, mean = 0.0, square = 0.0;
           for (std::size_t i = 0; i < x.size(); ++i) {
             sum += w[i];
             mean += w[i] * x[i];
             square += w[i] * x[i] * x[i];
           }
           mean /= sum;
           if (!is_line) return four::ramp(std::clamp(12.0 * (mean - 0.5), -1.8, 1.8));
           return four::logistic(mean, 0.66 * std::sqrt(std::max(0.25, square / sum - mean * mean)));
         };
         const auto result = gmis::estimate_adaptive(p.f, first, budget / 8, 8, fit, source);
         return Outcome{result.mean, static_cast<double>(result.samples.size()),
                        static_cast<double>(result.density_evaluations)};
       }},
      {"table of f",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& s) { return with_table(p, budget, s, false); }},
      {"table, compensated",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& s) { return with_table(p, budget, s, true); }},
      {"family, stochastic",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         return outcome_of(gmis::estimate_stochastic(p.f, family_of(p), 4, budget / 4, source));
       }},
      {"family, continuous",
       [](const four::Problem& p, std::uint32_t budget, gmis::Philox& source) {
         return outcome_of(gmis::estimate_continuous(p.f, family_of(p), 4, budget / 4, source));
       }},
  };
}

}  // namespace methods
