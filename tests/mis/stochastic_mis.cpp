#include "gmis/mis/methods/stochastic_mis.hpp"

#include <cmath>
#include <vector>

#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/methods/marginal_density.hpp"
#include "mis/method_oracles.hpp"
#include "support/catch.hpp"

namespace {

const std::vector<four::Problem> problems = four::problems();

/// The proposals of a problem that cover f alone (others would bias stochastic MIS), each drawn
/// with its probability.
struct Finite {
  std::vector<four::Density> proposals;
  std::vector<double> probabilities;
  std::size_t draw(gmis::UniformSource auto& source) const {
    double u = gmis::uniform<double>(source);
    std::size_t k = 0;
    while (k + 1 < proposals.size() && u >= probabilities[k]) u -= probabilities[k++];
    return k;
  }
  double sample(std::size_t k, gmis::UniformSource auto& source) const { return proposals[k].sample(source); }
  double pdf(std::size_t k, double x) const { return proposals[k].pdf(x); }
  double marginal_pdf(double x) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < proposals.size(); ++k) sum += probabilities[k] * proposals[k].pdf(x);
    return sum;
  }
};
Finite family_of(const four::Problem& problem) {
  Finite family;
  if (problem.breakpoints.front() < 0.0)
    family.proposals = {four::logistic(-2.0, 1.5), four::logistic(0.5, 1.2), four::logistic(3.0, 1.5)};
  else
    family.proposals = {four::uniform(0.0, 1.0), four::ramp(1.5), four::ramp(-1.0)};
  family.probabilities = {0.5, 0.3, 0.2};
  return family;
}
double bound_of(const four::Problem& problem) {
  return problem.breakpoints.front() < 0.0 ? 0.25 / 1.2 : 1.75;
}

/// A continuum: logistic with a centre uniform on [−3, 3).
struct Moving {
  double draw(gmis::UniformSource auto& source) const { return 6.0 * gmis::uniform<double>(source) - 3.0; }
  double sample(double t, gmis::UniformSource auto& source) const { return four::logistic(t, 1.0).sample(source); }
  double pdf(double t, double x) const { return four::logistic(t, 1.0).pdf(x); }
  double marginal_pdf(double x) const {  // ∫ over the centre: a difference of distributions
    return (1.0 / (1.0 + std::exp(-(x + 3.0))) - 1.0 / (1.0 + std::exp(-(x - 3.0)))) / 6.0;
  }
};
static_assert(gmis::KnownMarginal<Moving>);

}  // namespace

// 4 problems × 3 estimators × (mean, variance).
TEST_CASE("stochastic, continuous and marginal MIS: exact and measured", "[mis]") {
  const double level = test::sidak_level(1e-4, 24);
  gmis::Philox source(gmis_test::seed(81));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const Finite family = family_of(problem);
    const auto f = [&](double x) { return static_cast<long double>(problem.f(x)); };
    const long double integral = problem.integral;
    const auto check = [&](long double exact, auto estimate) {
      std::vector<double> rounds(20000);
      for (double& value : rounds) value = estimate();
      CHECK(test::mean_p_value(test::moments_of(rounds), problem.integral) > level);
      const auto interval = test::bootstrap_variance_interval(rounds, level, source);
      CAPTURE(interval.low, interval.high, exact);
      CHECK(interval.contains(static_cast<double>(exact)));
    };

    // Three techniques: all 27 draws, each with the variance of its balance heuristic; all have the
    // mean I.
    long double stochastic = 0.0L;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b)
        for (std::size_t c = 0; c < 3; ++c) {
          const auto d = [&](double x) {
            return static_cast<long double>(family.pdf(a, x)) + static_cast<long double>(family.pdf(b, x)) +
                   static_cast<long double>(family.pdf(c, x));
          };
          long double variance = test::integral(problem, [&](double x) { return f(x) * f(x) / d(x); });
          for (const std::size_t k : {a, b, c}) {
            const long double mean = test::integral(
                problem, [&](double x) { return static_cast<long double>(family.pdf(k, x)) * f(x) / d(x); });
            variance -= mean * mean;
          }
          stochastic +=
              static_cast<long double>(family.probabilities[a] * family.probabilities[b] * family.probabilities[c]) *
              variance;
        }
    check(stochastic, [&] { return gmis::estimate_stochastic(problem.f, family, 3, 1, source).mean; });

    const auto marginal = [&](double x) { return static_cast<long double>(family.marginal_pdf(x)); };
    const long double continuous =
        test::integral(problem, [&](double x) { return f(x) * f(x) / marginal(x); }) - integral * integral;
    check(continuous / 2.0L, [&] { return gmis::estimate_continuous(problem.f, family, 2, 1, source).mean; });
    CHECK(continuous / 3.0L < stochastic * 1.2L);

    const double bound = bound_of(problem);
    const long double with_trials =
        test::integral(problem,
                       [&](double x) {
                         return f(x) * f(x) * (2.0L - marginal(x) / static_cast<long double>(bound)) / marginal(x);
                       }) -
        integral * integral;
    check(with_trials / 2.0L, [&] { return gmis::estimate_marginal(problem.f, family, bound, 2, 1, source).mean; });
  }
}

TEST_CASE("stochastic MIS: a continuum of techniques", "[mis]") {
  const double level = test::sidak_level(1e-4, 5);
  gmis::Philox source(gmis_test::seed(82));
  const Moving family;
  const four::Problem& problem = problems[0];
  // Two techniques: the variance given both centres, averaged over them by the midpoint rule
  // (smooth in both).
  constexpr int places = 24;
  long double exact = 0.0L;
  for (int i = 0; i < places; ++i)
    for (int j = 0; j < places; ++j) {
      const double s = -3.0 + 6.0 * (i + 0.5) / places, t = -3.0 + 6.0 * (j + 0.5) / places;
      long double second = 0.0L, first = 0.0L, other = 0.0L;
      for (int n = -240; n <= 240; ++n) {  // trapezoidal rule: f vanishes beyond
        const double x = n / 24.0, density = family.pdf(s, x) + family.pdf(t, x);
        second += static_cast<long double>(problem.f(x) * problem.f(x) / density / 24.0);
        first += static_cast<long double>(family.pdf(s, x) * problem.f(x) / density / 24.0);
        other += static_cast<long double>(family.pdf(t, x) * problem.f(x) / density / 24.0);
      }
      exact += (second - first * first - other * other) / (places * places);
    }
  std::vector<double> rounds(20000);
  for (double& value : rounds) value = gmis::estimate_stochastic(problem.f, family, 2, 1, source).mean;
  CHECK(test::mean_p_value(test::moments_of(rounds), 1.0) > level);
  const auto interval = test::bootstrap_variance_interval(rounds, level, source);
  CAPTURE(interval.low, interval.high, exact);
  CHECK(interval.contains(static_cast<double>(exact)));

  for (double& value : rounds) value = gmis::estimate_continuous(problem.f, family, 2, 1, source).mean;
  CHECK(test::mean_p_value(test::moments_of(rounds), 1.0) > level);
  const long double continuous =
      test::integral(problem,
                     [&](double x) {
                       const long double f = problem.f(x);
                       return f > 0.0L ? f * f / static_cast<long double>(family.marginal_pdf(x)) : 0.0L;
                     }) -
      1.0L;
  CHECK(test::bootstrap_variance_interval(rounds, level, source).contains(static_cast<double>(continuous / 2.0L)));

  // 1/q itself: mean of K/B at a point.
  std::vector<double> inverses(20000);
  for (double& value : inverses) value = gmis::inverse_marginal_density(family, 1.3, 0.25, source).value;
  CHECK(test::mean_p_value(test::moments_of(inverses), 1.0 / family.marginal_pdf(1.3)) > level);
}

TEST_CASE("stochastic MIS: a finite family with equal probabilities is R2", "[mis]") {
  Finite family = family_of(problems[0]);
  family.probabilities = {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
  const gmis::TabulatedProblem table(problems[0].f, family.proposals, problems[0].nodes());
  gmis::Philox source(gmis_test::seed(83));
  std::vector<double> rounds(20000);
  for (double& value : rounds) value = gmis::estimate_stochastic(problems[0].f, family, 3, 1, source).mean;
  CHECK(test::bootstrap_variance_interval(rounds, 1e-5, source).contains(exact_variance(gmis::Scheme::R2, table)));
  CHECK_THROWS_AS(gmis::inverse_marginal_density(family, 0.5, 0.05, source), std::invalid_argument);
  CHECK(gmis::inverse_marginal_density(family, 1e4, 1.0, source, 10).value == 0.0);
  CHECK_THROWS_AS(gmis::estimate_stochastic(problems[0].f, family, 0, 1, source), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_marginal(problems[0].f, family, 0.0, 1, 1, source), std::invalid_argument);
}
