#include "gmis/mis/methods/weight_heuristic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "gmis/mis/methods/compensation.hpp"
#include "gmis/mis/methods/correlation_aware.hpp"
#include "gmis/mis/methods/pairwise.hpp"
#include "gmis/mis/methods/variance_aware.hpp"
#include "gmis/mis/multi_sample.hpp"
#include "mis/method_oracles.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

namespace {

using Counts = std::vector<std::uint32_t>;
const std::vector<four::Problem> problems = four::problems();

/// The weight of proposal k at x as its paper has it, in long double.
using WeightAt = long double (*)(const four::Problem&, const Counts&, const std::vector<double>& factors, std::size_t k,
                                 double x);
long double expected(const four::Problem& problem, const Counts& counts, std::size_t k, double x) {
  return counts[k] * static_cast<long double>(problem.proposals[k].pdf(x));
}
long double power_weight(const four::Problem& problem, const Counts& counts, const std::vector<double>&, std::size_t k,
                         double x) {
  long double sum = 0.0L;
  for (std::size_t j = 0; j < counts.size(); ++j)
    sum += expected(problem, counts, j, x) * expected(problem, counts, j, x);
  return expected(problem, counts, k, x) * expected(problem, counts, k, x) / sum;
}
long double scaled_weight(const four::Problem& problem, const Counts& counts, const std::vector<double>& factors,
                          std::size_t k, double x) {
  long double sum = 0.0L;
  for (std::size_t j = 0; j < counts.size(); ++j) sum += factors[j] * expected(problem, counts, j, x);
  return factors[k] * expected(problem, counts, k, x) / sum;
}
/// The canonical proposal: the one with the heaviest tails, so that contributions are bounded and
/// intervals hold.
std::size_t canonical_of(const four::Problem& problem) {
  return problem.f == four::span ? 2 : 0;
}
long double pairwise_weight(const four::Problem& problem, const Counts& counts, const std::vector<double>&,
                            std::size_t k, double x) {
  const std::size_t canonical = canonical_of(problem);
  long double others = 0.0L;
  for (std::size_t j = 0; j < counts.size(); ++j) others += j == canonical ? 0.0L : counts[j];
  // Two proposals alone, k standing for all others: (n − n_c) q_k beside n_c q_c.
  const long double c = expected(problem, counts, canonical, x);
  const auto pair = [&](std::size_t j) { return others * static_cast<long double>(problem.proposals[j].pdf(x)); };
  if (k != canonical) return counts[k] / others * pair(k) / (pair(k) + c);
  long double sum = 0.0L;
  for (std::size_t j = 0; j < counts.size(); ++j)
    if (j != canonical) sum += counts[j] / others * c / (pair(j) + c);
  return sum;
}

template <class H, class Estimate>
void check_heuristic(const H& heuristic, WeightAt weight, const std::vector<double>& factors,
                     const four::Problem& problem, const Counts& counts, double level, Estimate estimate,
                     gmis::Philox& source) {
  const auto oracle = test::moments_by_definition(problem, counts, [&](std::size_t k, double x) {
    return weight(problem, counts, factors, k, x) * static_cast<long double>(problem.f(x)) /
           expected(problem, counts, k, x);
  });
  const auto exact = gmis::exact_moments_with_weights(heuristic, counts, test::tabulated(problem));
  CHECK(exact.mean == Approx(problem.integral).epsilon(1e-9));
  CHECK(exact.variance == Approx(static_cast<double>(oracle.variance)).epsilon(1e-7).margin(1e-14));

  std::vector<double> rounds(20000);
  for (double& value : rounds) value = estimate();
  CHECK(test::mean_p_value(test::moments_of(rounds), problem.integral) > level);
  const auto interval = test::bootstrap_variance_interval(rounds, level, source);
  CAPTURE(interval.low, interval.high, exact.variance);
  CHECK((interval.contains(exact.variance) || exact.variance < 1e-14));
}

}  // namespace

// 4 problems × 2 counts × 5 heuristics × (mean, variance): 80 tests, false-alarm rate 1e-4 in all.
TEST_CASE("weight heuristics: exact and measured moments, as defined", "[mis]") {
  const double level = test::sidak_level(1e-4, 80);
  gmis::Philox source(gmis_test::seed(61));
  for (const four::Problem& problem : problems)
    for (const auto& counts : {problem.one_each(), test::uneven_counts(problem)}) {
      CAPTURE(problem.name, counts);
      const auto table = test::tabulated(problem);
      const auto measure = [&](const auto& heuristic) {
        return [&] {
          return gmis::estimate_with_weights(heuristic, problem.f, problem.proposals, counts, 1, source).mean;
        };
      };
      const gmis::RatioWeights<gmis::Power> power{{2.0}};
      check_heuristic(power, power_weight, {}, problem, counts, level, measure(power), source);

      for (const auto& variance_factors :
           {gmis::variance_aware_factors(table), gmis::variance_aware_factors_of_balance(counts, table)}) {
        const gmis::ScaledBalance variance_aware{variance_factors};
        check_heuristic(variance_aware, scaled_weight, variance_factors, problem, counts, level,
                        measure(variance_aware), source);
      }

      std::vector<double> correlations;
      for (std::size_t k = 0; k < counts.size(); ++k) correlations.push_back(0.2 * static_cast<double>(k % 4));
      const auto correlation_factors = gmis::correlation_aware_factors(counts, correlations);
      const gmis::ScaledBalance correlation_aware{correlation_factors};
      check_heuristic(correlation_aware, scaled_weight, correlation_factors, problem, counts, level,
                      measure(correlation_aware), source);

      const std::size_t canonical = canonical_of(problem);
      const gmis::Pairwise pairwise{canonical};
      check_heuristic(
          pairwise, pairwise_weight, {}, problem, counts, level,
          [&] { return gmis::estimate_pairwise(problem.f, problem.proposals, counts, canonical, 1, source).mean; },
          source);
    }
}

TEST_CASE("weight heuristics: those of one ratio are the same as before", "[mis]") {
  const four::Problem& problem = problems[2];
  const auto counts = test::uneven_counts(problem);
  const gmis::SampleAllocation<double> allocation{std::span<const std::uint32_t>(counts)};
  const auto compare = [&](const auto& heuristic) {
    gmis::Philox a(3), b(3);
    const auto listed = gmis::estimate_with_weights(gmis::RatioWeights<std::decay_t<decltype(heuristic)>>{heuristic},
                                                    problem.f, problem.proposals, counts, 300, a);
    const auto known = gmis::estimate_weighted(heuristic, problem.f, problem.proposals, 300, b, allocation);
    CHECK(listed.mean == Approx(known.mean).epsilon(1e-12));
    CHECK(listed.variance.value() == Approx(known.variance.value()).epsilon(1e-9));
    CHECK(listed.density_evaluations == known.density_evaluations);
  };
  compare(gmis::Balance{});
  compare(gmis::Power{3.0});
  compare(gmis::Cutoff{0.3});
  compare(gmis::Maximum{});
}

TEST_CASE("variance-aware factors: second moment over variance, alone and under the balance heuristic", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto counts = test::uneven_counts(problem);
    const auto alone = gmis::variance_aware_factors(test::tabulated(problem));
    const auto balanced = gmis::variance_aware_factors_of_balance(counts, test::tabulated(problem));
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const auto expected_factor = [&](auto divisor) {
        const auto moment = [&](int power) {
          return test::integral(problem, [&](double x) {
            const long double q = problem.proposals[k].pdf(x);
            return q > 0.0L ? q * std::pow(static_cast<long double>(problem.f(x)) / divisor(x),
                                           static_cast<long double>(power))
                            : 0.0L;
          });
        };
        const long double mean = moment(1), second = moment(2);
        return static_cast<double>(second / (second - mean * mean));
      };
      CAPTURE(k);
      CHECK(alone[k] == Approx(expected_factor([&](double x) {
                          return static_cast<long double>(problem.proposals[k].pdf(x));
                        })).epsilon(1e-6));
      CHECK(balanced[k] == Approx(expected_factor([&](double x) {
                             return test::expected_density(problem, counts, x);
                           })).epsilon(1e-6));
    }
  }
  // Closed form: f = 2 x under the density 1 has E[y]² = 1, Var = 1/3.
  const std::vector<test::Uniform> unit{{0.0, 1.0}, {0.0, 1.0}};
  const std::array<double, 2> ends{0.0, 1.0};
  const auto nodes = gmis::composite_gauss_legendre(ends, 2);
  const gmis::TabulatedProblem line([](double x) { return 2.0 * x; }, unit, nodes);
  CHECK(gmis::variance_aware_factors(line)[0] == Approx(4.0).epsilon(1e-12));
  CHECK(gmis::variance_aware_factors_of_balance(Counts{3, 5}, line)[1] == Approx(4.0).epsilon(1e-12));
  // Without variance the factor is bounded; without samples, and without a contribution, it is 1.
  const gmis::TabulatedProblem flat([](double) { return 2.0; }, unit, nodes);
  CHECK(gmis::variance_aware_factors(flat, 50.0) == std::vector<double>{50.0, 50.0});
  CHECK(gmis::variance_aware_factors_of_balance(Counts{2, 0}, flat, 50.0) == std::vector<double>{50.0, 1.0});
  const gmis::TabulatedProblem nothing([](double) { return 0.0; }, unit, nodes);
  CHECK(gmis::variance_aware_factors(nothing) == std::vector<double>{1.0, 1.0});
  // A proposal that fails every other time: E[y²] = 2, Var = 1.
  const std::vector<double> value{1.0}, weight{1.0}, density{0.5};
  const gmis::TabulatedProblem failing(value, weight, density);
  CHECK(gmis::variance_aware_factors(failing)[0] == Approx(2.0));
  CHECK(gmis::variance_aware_factors_of_balance(Counts{1}, failing)[0] == Approx(2.0));
  // A density that passes through denormals where f does not: the variance is infinite, and the
  // factor 1.
  const std::vector<double> two{1.0, 1.0};
  for (const double thin : {5e-324, 1e-200})  // f/q_k out of range, or its square
    CHECK(gmis::variance_aware_factors(gmis::TabulatedProblem(two, two, {1.0, thin}))[0] == 1.0);
  const std::vector<double> huge{1e200, 1e200};
  CHECK(gmis::variance_aware_factors(gmis::TabulatedProblem(huge, two, {1.0, 1e-100}))[0] == 1.0);
  CHECK_THROWS_AS(gmis::variance_aware_factors(flat, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(gmis::variance_aware_factors_of_balance(Counts{1, 1}, flat, std::nan("")), std::invalid_argument);
}

namespace {

/// Samples of a proposal that share a quarter of its distribution: the first of each `counts[k]`
/// draws the quarter for all.
struct Clustered {
  using Value = double;
  using Density = double;
  const four::Problem& problem;
  Counts counts;
  mutable std::vector<std::uint32_t> made, quarter;

  Clustered(const four::Problem& p, Counts c) : problem(p), counts(std::move(c)), made(counts.size()), quarter(made) {}
  struct Fixed {
    std::uint64_t word;
    using result_type = std::uint64_t;
    static constexpr result_type min() { return 0; }
    static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
    result_type operator()() const { return word; }
  };
  static double at(const four::Density& q, double u) {
    Fixed fixed{static_cast<std::uint64_t>(u * 0x1p53) << 11U};
    return q.sample(fixed);
  }
  std::size_t size() const { return counts.size(); }
  double sample(std::size_t k, gmis::UniformSource auto& source) const {
    if (made[k]++ % counts[k] == 0) quarter[k] = gmis::uniform_index(source, 4);
    return at(problem.proposals[k], 0.25 * (quarter[k] + gmis::uniform<double>(source)));
  }
  double pdf(std::size_t k, double x) const { return problem.proposals[k].pdf(x); }
};

struct ClusterMoments {
  long double mean, within,
      between;  ///< of one sample: mean, mean variance within a quarter, variance between quarters
};
template <class H>
ClusterMoments cluster_moments(const four::Problem& problem, std::size_t k, H h) {
  const four::Density& q = problem.proposals[k];
  std::vector<double> cuts{problem.breakpoints.front(), Clustered::at(q, 0.25), Clustered::at(q, 0.5),
                           Clustered::at(q, 0.75), problem.breakpoints.back()};
  ClusterMoments result{0.0L, 0.0L, 0.0L};
  long double squares = 0.0L;
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<double> places{cuts[c]};
    for (const double place : problem.breakpoints)
      if (place > cuts[c] && place < cuts[c + 1]) places.push_back(place);
    places.push_back(cuts[c + 1]);
    const auto moment = [&](int power) {
      return 4.0L * test::integral_over(places, [&](double x) {
               const long double density = q.pdf(x);
               return density > 0.0L ? density * (power == 1 ? h(x) : h(x) * h(x)) : 0.0L;
             });
    };
    const long double mean = moment(1);
    result.mean += mean / 4.0L;
    squares += mean * mean / 4.0L;
    result.within += (moment(2) - mean * mean) / 4.0L;
  }
  result.between = squares - result.mean * result.mean;
  return result;
}

}  // namespace

// Proposal 0 makes 6 samples a round from one quarter of its distribution. 4 problems × 2
// heuristics × (mean, variance).
TEST_CASE("correlation-aware weights: correlated samples, exact and measured", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(62));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    Counts counts = problem.one_each();
    counts[0] = 6;
    std::vector<double> correlations(counts.size());
    const auto balance = cluster_moments(problem, 0, [&](double x) {
      return static_cast<long double>(problem.f(x)) / test::expected_density(problem, counts, x);
    });
    correlations[0] = static_cast<double>(balance.between / (balance.between + balance.within));
    CHECK(correlations[0] > 0.1);
    const auto factors = gmis::correlation_aware_factors(counts, correlations);
    CHECK(factors[0] == Approx(1.0 / (1.0 + 5.0 * correlations[0])).epsilon(1e-12));
    const std::vector<double> ones(counts.size(), 1.0);
    long double variances[2];
    for (const bool aware : {false, true}) {
      const auto& used = aware ? factors : ones;
      long double variance = 0.0L;
      for (std::size_t k = 0; k < counts.size(); ++k) {
        const auto m = cluster_moments(problem, k, [&](double x) {
          return scaled_weight(problem, counts, used, k, x) * static_cast<long double>(problem.f(x)) /
                 expected(problem, counts, k, x);
        });
        variance += counts[k] * m.within + counts[k] * counts[k] * m.between;
      }
      variances[aware] = variance;
      const Clustered set(problem, counts);
      std::vector<double> rounds(20000);
      for (double& value : rounds)
        value = gmis::estimate_with_weights(gmis::ScaledBalance{used}, problem.f, set, counts, 1, source).mean;
      CHECK(test::mean_p_value(test::moments_of(rounds), problem.integral) > level);
      const auto interval = test::bootstrap_variance_interval(rounds, level, source);
      CAPTURE(aware, interval.low, interval.high, variance);
      CHECK(interval.contains(static_cast<double>(variance)));
    }
    CHECK(variances[1] < 0.9L * variances[0]);
  }
  CHECK_THROWS_AS(gmis::correlation_aware_factors(Counts{1, 2}, std::vector<double>{0.5, 1.5}), std::invalid_argument);
  CHECK_THROWS_AS(gmis::correlation_aware_factors(Counts{1, 2}, std::vector<double>{0.5}), std::invalid_argument);
}

TEST_CASE("correlation-aware factor of one path: its limits, and its definition", "[mis]") {
  using gmis::correlation_aware_factor;
  CHECK(correlation_aware_factor(1, 0.0, 1.0) == 1.0);    // one sample has nothing to be correlated with
  CHECK(correlation_aware_factor(10, 0.0, 1.0) == 0.1);   // all that differs is sure, what is shared is not
  CHECK(correlation_aware_factor(10, 1.0, 1e-9) == 1.0);  // what is shared is sure
  CHECK(correlation_aware_factor(10, 0.0, 0.0) == 1.0);
  for (const double shared : {1e-12, 1e-3, 0.2, 0.5, 1.0})
    for (const double rest : {0.0, 1e-12, 1e-3, 0.2, 0.5, 1.0})
      for (const std::uint32_t count : {1U, 2U, 1000U}) {
        const long double p = shared, q = rest;
        const long double either = 1.0L - (1.0L - p) * (1.0L - q);  // that one or the other comes to the place
        const long double expected = std::max(1.0L / count, p / either);
        CAPTURE(shared, rest, count);
        CHECK(correlation_aware_factor(count, shared, rest) == Approx(static_cast<double>(expected)).epsilon(1e-6));
        CHECK(correlation_aware_factor(count, shared, rest) <= 1.0);
      }
  CHECK_THROWS_AS(correlation_aware_factor(0, 0.5, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(correlation_aware_factor(2, 1.5, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(correlation_aware_factor(2, 0.5, std::nan("")), std::invalid_argument);
}

TEST_CASE("compensation: no other table has a smaller second moment", "[mis]") {
  std::mt19937_64 engine(gmis_test::seed(63));
  for (const four::Problem& problem : problems)
    for (const double fraction : {0.2, 0.5, 0.9, 1.0}) {
      CAPTURE(problem.name, fraction);
      constexpr std::size_t cells = 24;
      const double low = problem.breakpoints.front() < 0.0 ? -8.0 : 0.0, high = low < 0.0 ? 8.0 : 1.0;
      std::vector<double> target(cells), others(cells);
      for (std::size_t i = 0; i < cells; ++i) {
        const double x = low + (high - low) * (static_cast<double>(i) + 0.5) / cells;
        target[i] = std::abs(problem.f(x));
        others[i] = problem.proposals[1].pdf(x) * (high - low) / cells;
      }
      const auto best = gmis::compensated_density(target, others, fraction);
      CHECK(std::accumulate(best.begin(), best.end(), 0.0) == Approx(1.0).epsilon(1e-12));
      const auto second_moment = [&](const std::vector<double>& density) {
        long double sum = 0.0L;
        for (std::size_t i = 0; i < cells; ++i) {
          const long double t = target[i];
          const long double psi = fraction * static_cast<long double>(density[i]) +
                                  (1.0L - static_cast<long double>(fraction)) * static_cast<long double>(others[i]);
          if (t > 0.0L) sum += psi > 0.0L ? t * t / psi : 1e300L;
        }
        return sum;
      };
      const long double least = second_moment(best);
      for (int trial = 0; trial < 200; ++trial) {
        std::vector<double> other(cells);
        double sum = 0.0;
        const double distance = trial % 2 == 0 ? 0.5 : 0.02;
        for (std::size_t i = 0; i < cells; ++i) {
          other[i] = (1.0 - distance) * best[i] + distance * target[i] * -std::log(1.0 - gmis::uniform<double>(engine));
          sum += other[i];
        }
        for (double& p : other) p /= sum;
        CHECK(second_moment(other) >= least * (1.0L - 1e-12L));
      }
      if (fraction == 0.5) {  // the rule of thumb for skies: the target less its mean, which does without λ
        std::vector<double> thumb(cells);
        const double mass = std::accumulate(target.begin(), target.end(), 0.0);
        double sum = 0.0;
        for (std::size_t i = 0; i < cells; ++i) sum += thumb[i] = std::max(0.0, target[i] / mass - others[i]);
        for (double& p : thumb) p /= sum;
        CHECK(second_moment(thumb) >= least * (1.0L - 1e-12L));
      }
      if (fraction == 1.0) {  // alone: in proportion to the target
        const double mass = std::accumulate(target.begin(), target.end(), 0.0);
        for (std::size_t i = 0; i < cells; ++i) CHECK(best[i] == Approx(target[i] / mass).margin(1e-12));
      }
    }
  const std::vector<double> one{1.0}, none{0.0}, negative{-1.0}, two{1.0, 1.0};
  CHECK(gmis::compensated_density(one, one, 0.5) == one);
  CHECK_THROWS_AS(gmis::compensated_density(none, one, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(gmis::compensated_density(one, negative, 0.5), std::invalid_argument);
  const std::vector<double> many{1e300};  // no probability; the difference would be rounding alone
  CHECK_THROWS_AS(gmis::compensated_density(one, many, 0.5), std::invalid_argument);
  const std::vector<double> tiny{5e-324, 1e-323};             // any mass serves
  CHECK(gmis::compensated_density(one, one, 1e-300) == one);  // and any fraction
  const std::vector<double> halves{0.5, 0.5};
  CHECK(gmis::compensated_density(tiny, halves, 1.0)[1] == Approx(2.0 / 3.0));
  CHECK_THROWS_AS(gmis::compensated_density(one, two, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(gmis::compensated_density(one, one, 0.0), std::invalid_argument);
}

TEST_CASE("pairwise weights: cost, logarithms, arguments", "[mis]") {
  gmis::Philox source(gmis_test::seed(64));
  const four::Problem& problem = problems[3];
  const auto counts = test::uneven_counts(problem);  // 1, 3, 2, 1, 3, 2
  const auto estimate = gmis::estimate_pairwise(problem.f, problem.proposals, counts, 5, 10, source);
  CHECK(estimate.samples == 120);
  CHECK(estimate.density_evaluations == 10 * (2 * 10 + 6 * 2));
  const std::array<test::Normal3, 3> logs{{{{0.5, 0.0, 0.0}, 1.2}, {{-0.5, 0.2, 0.0}, 1.4}, {{0.0, 0.2, 0.4}, 1.3}}};
  const test::Normal3 centre{{0.0, 0.0, 0.0}, 1.0};
  const auto f = [&](const glm::dvec3& x) { return std::exp(centre.log_pdf(x)); };
  const auto from_logs = gmis::estimate_pairwise(f, logs, Counts{1, 2, 3}, 2, 3000, source);
  CHECK(test::normal_p_value((from_logs.mean - 1.0) / from_logs.standard_error.value()) > 1e-5);
  const auto listed = gmis::estimate_with_weights(gmis::Pairwise{2}, f, logs, Counts{1, 2, 3}, 3000, source);
  CHECK(test::normal_p_value((listed.mean - 1.0) / listed.standard_error.value()) > 1e-5);
  const std::array<test::Normal3, 1> alone{{{{0.5, 0.0, 0.0}, 1.2}}};
  const auto single = gmis::estimate_pairwise(f, alone, Counts{2}, 0, 3000, source);
  CHECK(test::normal_p_value((single.mean - 1.0) / single.standard_error.value()) > 1e-5);
  std::vector<double> weights(2);
  gmis::Pairwise{1}.weights(Counts{0, 2}, std::vector<double>{0.5, 0.5}, weights);  // nobody else has samples
  CHECK(weights == std::vector<double>{0.0, 1.0});
  gmis::Pairwise{1}.weights(Counts{3, 2}, std::vector<double>{0.5, 0.0}, weights);
  CHECK(weights == std::vector<double>{1.0, 0.0});
  const auto only = gmis::estimate_pairwise(f, std::array{alone[0], logs[1]}, Counts{2, 0}, 0, 3000, source);
  CHECK(test::normal_p_value((only.mean - 1.0) / only.standard_error.value()) > 1e-5);
  CHECK_THROWS_AS(gmis::estimate_pairwise(f, logs, Counts{1, 2, 3}, 3, 10, source), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_pairwise(f, logs, Counts{1, 2, 0}, 2, 10, source), std::invalid_argument);
}
