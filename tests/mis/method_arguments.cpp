#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/methods.hpp"
#include "mis/method_oracles.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

// Wrong arguments of the methods, each of them; what a set, a source and an integrand may be.

namespace {

using Counts = std::vector<std::uint32_t>;
using Numbers = std::vector<double>;
#define REJECTED(...) CHECK_THROWS_AS((void)(__VA_ARGS__), std::invalid_argument)

const four::Problem problem = four::problems()[0];
const Counts ones{1, 1, 1};
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// One technique, uniform on [0, 1).
struct UnitFamily {
  int draw(gmis::UniformSource auto&) const { return 0; }
  double sample(int, gmis::UniformSource auto& source) const { return gmis::uniform<double>(source); }
  double pdf(int, double) const { return 1.0; }
  double marginal_pdf(double) const { return 1.0; }
};

/// Uniform with a density that is wrong; a negative one: makes no samples.
struct Faulty {
  double density;
  std::optional<double> sample(gmis::UniformSource auto& s) const {
    if (density < 0.0) return std::nullopt;
    return gmis::uniform<double>(s);
  }
  double pdf(double) const { return density < 0.0 ? 0.0 : density; }
};

/// Every method that takes counts and rounds, by number.
constexpr int method_count = 9;
double run(int method, const std::vector<four::Density>& proposals, const Counts& counts, std::uint64_t rounds,
           gmis::UniformSource auto& source) {
  const auto f = problem.f;
  switch (method) {
    case 0:
      return gmis::estimate_controlled(f, proposals, counts, Numbers(proposals.size(), 0.1), rounds, source).mean;
    case 1:
      return gmis::estimate_optimal_progressive(f, proposals, counts, rounds, source).mean;
    case 2:
      return gmis::estimate_optimal_direct(f, proposals, counts, rounds, source).mean;
    case 3:
      return gmis::estimate_with_weights(gmis::RatioWeights<gmis::Power>{{2.0}}, f, proposals, counts, rounds, source)
          .mean;
    case 4:
      return gmis::estimate_pairwise(f, proposals, counts, 0, rounds, source).mean;
    case 5:
      return gmis::estimate_resampled(f, f, proposals, counts, rounds, source).mean;
    case 6:
      return gmis::estimate_self_normalised(
                 f, [](double x) { return std::array{x}; }, proposals, counts, rounds, source)
          .normaliser;
    case 7: {
      std::vector<four::Density> moved = proposals;
      const auto move = [](const four::Density& q, double) { return q; };
      return gmis::estimate_population(f, moved, counts.empty() ? 0 : counts[0], rounds, move, source).mean;
    }
    default: {
      gmis::ScrambledSobol points(7);
      return gmis::estimate_rqmc(f, proposals, counts, rounds, points).mean;
    }
  }
}

}  // namespace

TEST_CASE("methods: counts, rounds and sets that cannot serve", "[mis]") {
  gmis::Philox source(1);
  const std::vector<four::Density> none;
  for (int method = 0; method < method_count; ++method) {
    CAPTURE(method);
    CHECK_NOTHROW(run(method, problem.proposals, ones, 3, source));
    REJECTED(run(method, problem.proposals, ones, 0, source));
    REJECTED(run(method, problem.proposals, ones, static_cast<std::uint64_t>(-1), source));
    REJECTED(run(method, none, Counts{}, 3, source));
    REJECTED(run(method, problem.proposals, Counts{0, 0, 0}, 3, source));
    if (method == 7) continue;  // takes one count for all
    REJECTED(run(method, problem.proposals, Counts{1, 1}, 3, source));
    REJECTED(run(method, problem.proposals, Counts{1, 1, 1, 1}, 3, source));
  }
}

TEST_CASE("methods: every engine of <random> serves, and proposals for one engine", "[mis]") {
  std::default_random_engine standard(static_cast<unsigned>(gmis_test::seed(101)));
  std::mt19937 twister(static_cast<unsigned>(gmis_test::seed(102)));
  for (int method = 0; method < method_count; ++method) {
    CAPTURE(method);
    CHECK(run(method, problem.proposals, ones, 4000, standard) == Approx(1.0).epsilon(0.2));
    CHECK(run(method, problem.proposals, ones, 4000, twister) == Approx(1.0).epsilon(0.2));
  }
  struct OfTwister {
    double low;
    double sample(std::mt19937& engine) const { return low + std::uniform_real_distribution<double>()(engine); }
    double pdf(double x) const { return x >= low && x < low + 1.0 ? 1.0 : 0.0; }
  };
  const std::array<OfTwister, 2> proposals{{{0.0}, {0.0}}};
  const auto is_low = [](double x) { return x < 0.25; };  // a bool is a number
  const auto count = [](double x) { return x < 0.25 ? 3 : 0; };
  const Counts two{1, 1};
  // 0.05 is 4.9 standard errors of the resampled estimate and 6.9 or more of the others: a false
  // alarm in 1.2e-6 of seeds.
  constexpr std::uint64_t rounds = 16000;
  const auto near = [](double value, double truth) { CHECK(value == Approx(truth).margin(0.05)); };
  near(gmis::estimate_optimal_progressive(is_low, proposals, two, rounds, twister).mean, 0.25);
  near(gmis::estimate_optimal_direct(count, proposals, two, rounds, twister).mean, 0.75);
  near(gmis::estimate_controlled(count, proposals, two, Numbers{0.3, 0.4}, rounds, twister).mean, 0.75);
  near(gmis::estimate_with_weights(gmis::Pairwise{0}, count, proposals, two, rounds, twister).mean, 0.75);
  near(gmis::estimate_pairwise(count, proposals, two, 0, rounds, twister).mean, 0.75);
  near(gmis::estimate_resampled(
           count, [](double) { return 1; }, proposals, two, rounds, twister)
           .mean,
       0.75);
  const auto first = proposals[0];
  near(gmis::estimate_adaptive(
           is_low, first, 2000, 2, [&](auto, auto) { return first; }, twister)
           .mean,
       0.25);
  std::vector<OfTwister> moved(2, first);
  const auto stay = [](const OfTwister& q, double) { return q; };
  near(gmis::estimate_population(count, moved, 2, rounds / 2, stay, twister).mean, 0.75);
  struct Family {
    int draw(std::mt19937&) const { return 0; }
    double sample(int, std::mt19937& engine) const { return std::uniform_real_distribution<double>()(engine); }
    double pdf(int, double) const { return 1.0; }
    double marginal_pdf(double) const { return 1.0; }
  };
  near(gmis::estimate_stochastic(count, Family{}, 2, rounds, twister).mean, 0.75);
  near(gmis::estimate_continuous(count, Family{}, 2, rounds, twister).mean, 0.75);
  near(gmis::estimate_marginal(count, Family{}, 1.0, 2, rounds, twister).mean, 0.75);
}

TEST_CASE("methods: arguments of their own", "[mis]") {
  gmis::Philox source(1);
  const auto& q = problem.proposals;
  REJECTED(gmis::estimate_controlled(problem.f, q, ones, Numbers{0.1, 0.2}, 3, source));
  REJECTED(gmis::estimate_pairwise(problem.f, q, ones, 3, 3, source));
  REJECTED(gmis::estimate_pairwise(problem.f, q, Counts{0, 1, 1}, 0, 3, source));
  REJECTED(gmis::estimate_with_weights(gmis::Pairwise{3}, problem.f, q, ones, 3, source));
  REJECTED(gmis::estimate_with_weights(gmis::Pairwise{0}, problem.f, q, Counts{0, 1, 1}, 3, source));
  for (const Numbers& factors : {Numbers{1.0, 1.0}, Numbers{1.0, 1.0, 0.0}, Numbers{1.0, 1.0, -1.0},
                                 Numbers{1.0, 1.0, not_a_number}, Numbers{1.0, 1.0, HUGE_VAL}})
    REJECTED(gmis::estimate_with_weights(gmis::ScaledBalance{factors}, problem.f, q, ones, 3, source));
  REJECTED(gmis::estimate_with_weights(gmis::RatioWeights<gmis::Cutoff>{{1.5}}, problem.f, q, ones, 3, source));
  const auto keep = [&](auto, auto) { return q[0]; };
  REJECTED(gmis::estimate_adaptive(problem.f, q[0], 0, 3, keep, source));
  REJECTED(gmis::estimate_adaptive(problem.f, q[0], 3, 0, keep, source));
  const UnitFamily family;
  REJECTED(gmis::estimate_stochastic(problem.f, family, 2, 0, source));
  REJECTED(gmis::estimate_continuous(problem.f, family, 0, 2, source));
  REJECTED(gmis::estimate_continuous(problem.f, family, 2, 0, source));
  REJECTED(gmis::estimate_marginal(problem.f, family, 1.0, 2, 0, source));
  REJECTED(gmis::estimate_marginal(problem.f, family, not_a_number, 2, 2, source));
  REJECTED(gmis::estimate_marginal(problem.f, family, 0.5, 2, 2, source));

  const auto table = test::tabulated(problem);
  REJECTED(gmis::exact_moments_controlled(ones, Numbers{0.1}, table));
  REJECTED(gmis::exact_moments_with_weights(gmis::ScaledBalance{Numbers{1.0}}, ones, table));
  REJECTED(gmis::exact_moments_with_weights(gmis::Pairwise{7}, ones, table));
  REJECTED(gmis::exact_moments_with_weights(gmis::Pairwise{0}, Counts{1}, table));
  REJECTED(gmis::exact_moments(gmis::CountsByProposal(Counts{1, 1}), table));
  REJECTED(gmis::exact_moments_of_mixture(Numbers{0.5, 0.5}, 1, table));
  REJECTED(gmis::exact_moments_of_resampling(ones, Numbers{1.0}, table));
  REJECTED(gmis::control_coefficients(Counts{1, 1}, table));
  REJECTED(gmis::variance_aware_factors_of_balance(Counts{1, 1}, table));
  REJECTED(gmis::variance_aware_factors(table, 0.5));
  REJECTED(gmis::optimal_fractions(table, Numbers{1.0}));
  REJECTED(gmis::optimal_fractions(table, Numbers{1.0, -1.0, 1.0}));
  REJECTED(gmis::optimal_fractions(table, {}, 0.5));
  REJECTED(gmis::inverse_variance_fractions(table, Numbers{1.0, 0.0, 1.0}));
  REJECTED(gmis::optimal_counts(table, 0));
  REJECTED(gmis::best_groups(table, 4));
}

TEST_CASE("methods: what goes wrong with samples is counted", "[mis]") {
  gmis::Philox source(1);
  const std::array<Faulty, 4> proposals{{{-1.0}, {0.0}, {not_a_number}, {1.0}}};
  const auto one = [](double) { return 1.0; };
  const auto alone = [&](std::size_t k) {
    Counts counts(4);
    counts[k] = 2;
    const std::array<Faulty, 1> set{proposals[k]};
    return gmis::estimate_with_weights(gmis::RatioWeights<gmis::Balance>{}, one, set, Counts{2}, 5, source);
  };
  CHECK(alone(0).failed_samples == 10);
  CHECK(alone(1).rejected.zero_density == 10);
  CHECK(alone(2).rejected.non_finite_density == 10);
  CHECK(alone(3).rejected.total() == 0);
  const std::array<Faulty, 1> tiny{{{1e-300}}};
  const auto huge = [](double) { return 1e300; };
  const auto overflow =
      gmis::estimate_with_weights(gmis::RatioWeights<gmis::Balance>{}, huge, tiny, Counts{2}, 5, source);
  CHECK(overflow.rejected.non_finite_contribution == 10);
  CHECK(overflow.mean == 0.0);
  struct FaultyFamily : UnitFamily {
    double density;
    double pdf(int, double) const { return density; }
    double marginal_pdf(double) const { return density; }
  };
  for (const double density : {0.0, not_a_number}) {
    CAPTURE(density);
    const FaultyFamily family{{}, density};
    const gmis::Rejected expected = density == 0.0 ? gmis::Rejected{0, 10, 0, 0} : gmis::Rejected{0, 0, 10, 0};
    CHECK(gmis::estimate_stochastic(one, family, 2, 5, source).rejected == expected);
    CHECK(gmis::estimate_continuous(one, family, 2, 5, source).rejected == expected);
  }
}

TEST_CASE("methods: a fault in the density of a proposal without samples is counted", "[mis]") {
  const auto f = [](double x) { return x > 0.5 ? 1e6 : 1.0; };
  const Counts counts{4, 0};
  const double infinity = std::numeric_limits<double>::infinity();
  const auto check = [&](const auto& proposals, bool is_fault) {
    gmis::Philox source(gmis_test::seed(104));
    const auto each = [&](const auto& estimate) {
      CHECK(std::isfinite(estimate.mean));
      const gmis::Rejected& rejected = estimate.rejected;
      CHECK(rejected.total() == rejected.non_finite_density);
      // Half of 4000 samples: 2000 ± 31.7, six standard deviations.
      CHECK(std::abs(static_cast<double>(rejected.total()) - (is_fault ? 2000.0 : 0.0)) < 6.0 * 31.7);
      return estimate.mean;
    };
    each(gmis::estimate_optimal_progressive(f, proposals, counts, 1000, source));
    each(gmis::estimate_optimal_direct(f, proposals, counts, 1000, source));
    const double controlled = each(gmis::estimate_controlled(f, proposals, counts, Numbers{0.5, 0.0}, 1000, source));
    const double weighted =
        each(gmis::estimate_with_weights(gmis::RatioWeights<gmis::Balance>{}, f, proposals, counts, 1000, source));
    CHECK((controlled < 2.0) == is_fault);  // 500000 where the samples above one half count
    CHECK((weighted < 2.0) == is_fault);
  };
  for (const double fault : {not_a_number, infinity, -1.0, 0.0, 1e-300}) {
    CAPTURE(fault);
    check(std::array<test::FaultyDensity, 2>{{{1.0}, {fault}}}, !(fault >= 0.0 && fault < infinity));
  }
  for (const double log_fault : {not_a_number, infinity, -infinity, -2000.0, 30.0}) {
    CAPTURE(log_fault);
    check(std::array<test::FaultyLogarithm, 2>{{{0.0}, {log_fault}}}, !(log_fault < infinity));
  }
  // A density of e^600 without samples leaves the mixture of the others as it is.
  gmis::Philox source(gmis_test::seed(104)), same(gmis_test::seed(104));
  const auto mean = [&](double log_density, gmis::Philox& s) {
    const std::array<test::FaultyLogarithm, 2> proposals{{{0.0}, {log_density}}};
    return gmis::estimate_with_weights(gmis::RatioWeights<gmis::Balance>{}, f, proposals, counts, 100, s).mean;
  };
  CHECK(mean(600.0, source) == mean(0.0, same));
}

TEST_CASE("methods: what trials cost", "[mis]") {
  gmis::Philox source(gmis_test::seed(103));
  // Each sample needs trials with success 1/4: 4 on average, variance 12. False-alarm rate 1e-5.
  const auto estimate = gmis::estimate_marginal([](double x) { return x; }, UnitFamily{}, 4.0, 10, 2000, source);
  const double trials = static_cast<double>(estimate.density_evaluations);
  CHECK(test::normal_p_value((trials - 4.0 * 20000.0) / std::sqrt(12.0 * 20000.0)) > 1e-5);
  CHECK(gmis::estimate_stochastic([](double x) { return x; }, UnitFamily{}, 3, 7, source).density_evaluations == 63);
  CHECK(gmis::estimate_continuous([](double x) { return x; }, UnitFamily{}, 3, 7, source).density_evaluations == 21);
}

TEST_CASE("coefficients of control variates are numbers", "[mis]") {
  gmis::Philox source(1);
  const gmis::TabulatedProblem table(problem.f, problem.proposals, problem.nodes());
  for (const double wrong : {not_a_number, std::numeric_limits<double>::infinity()}) {
    const Numbers coefficients{0.1, wrong, 0.1};
    REJECTED(gmis::estimate_controlled(problem.f, problem.proposals, ones, coefficients, 2, source));
    REJECTED(gmis::exact_moments_controlled(ones, coefficients, table));
  }
}

TEST_CASE("the fractions of a mixture sum to one", "[mis]") {
  const gmis::TabulatedProblem table(problem.f, problem.proposals, problem.nodes());
  REJECTED(gmis::exact_moments_of_mixture(Numbers{0.6, 0.6, 0.6}, 3, table));
  REJECTED(gmis::exact_moments_of_mixture(Numbers{1.5, -0.5, 0.0}, 3, table));
  REJECTED(gmis::exact_moments_of_mixture(Numbers{0.5, 0.5, not_a_number}, 3, table));
  REJECTED(gmis::exact_moments_of_mixture(Numbers{0.5, 0.5, 0.0}, 0, table));
  CHECK(gmis::exact_moments_of_mixture(Numbers{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 3, table).variance > 0.0);
}

// Factors that end before the weights do: once a span of a temporary.
TEST_CASE("scaled balance weights keep their factors", "[mis]") {
  const gmis::TabulatedProblem table(problem.f, problem.proposals, problem.nodes());
  const Numbers factors = gmis::variance_aware_factors(table);
  const gmis::ScaledBalance from_temporary{gmis::variance_aware_factors(table)};
  std::vector<Numbers> overwritten;
  for (int i = 0; i < 100; ++i) overwritten.emplace_back(factors.size(), 1e3);
  CHECK(from_temporary.factors == factors);
  CHECK(gmis::exact_moments_with_weights(from_temporary, ones, table).variance ==
        gmis::exact_moments_with_weights(gmis::ScaledBalance{factors}, ones, table).variance);
}
