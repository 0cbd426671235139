#include "gmis/mis/methods/optimal_weights.hpp"

#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <vector>

#include "gmis/mis/diagnostics/best_scheme.hpp"
#include "gmis/testing/catch.hpp"
#include "mis/method_oracles.hpp"
#include "support/catch.hpp"

namespace {

const std::vector<four::Problem> problems = four::problems();

/// Coefficients from the normal equations, in long double by Gauss and Jordan; the matrices are
/// regular in all four.
std::vector<double> coefficients_by_definition(const four::Problem& problem, const std::vector<std::uint32_t>& counts) {
  const std::size_t n = counts.size();
  std::vector<std::vector<long double>> rows(n, std::vector<long double>(n + 1));
  for (std::size_t i = 0; i < n; ++i) {
    const auto with = [&](auto g) {
      return test::integral(problem, [&](double x) {
        const long double d = test::expected_density(problem, counts, x);
        return d > 0.0L ? static_cast<long double>(problem.proposals[i].pdf(x)) * static_cast<long double>(g(x)) / d
                        : 0.0L;
      });
    };
    for (std::size_t j = 0; j < n; ++j) rows[i][j] = with([&](double x) { return problem.proposals[j].pdf(x); });
    rows[i][n] = with(problem.f);
  }
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t best = p;
    for (std::size_t i = p; i < n; ++i)
      if (std::abs(rows[i][p]) > std::abs(rows[best][p])) best = i;
    std::swap(rows[p], rows[best]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == p) continue;
      const long double factor = rows[i][p] / rows[p][p];
      for (std::size_t j = p; j <= n; ++j) rows[i][j] -= factor * rows[p][j];
    }
  }
  std::vector<double> beta(n);
  for (std::size_t i = 0; i < n; ++i) beta[i] = static_cast<double>(rows[i][n] / rows[i][i]);
  return beta;
}

long double variance_by_definition(const four::Problem& problem, const std::vector<std::uint32_t>& counts,
                                   const std::vector<double>& beta) {
  return test::moments_by_definition(problem, counts,
                                     [&](std::size_t, double x) {
                                       long double residual = problem.f(x);
                                       for (std::size_t k = 0; k < beta.size(); ++k)
                                         residual -= static_cast<long double>(beta[k]) *
                                                     static_cast<long double>(problem.proposals[k].pdf(x));
                                       return residual / test::expected_density(problem, counts, x);
                                     })
      .variance;
}

}  // namespace

TEST_CASE("counted variance: N3 with counts and mixtures, as defined", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto table = test::tabulated(problem);
    CHECK(table.integral() == Approx(problem.integral).epsilon(1e-10));
    for (const auto& counts : {problem.one_each(), test::uneven_counts(problem)}) {
      const auto oracle = test::moments_by_definition(problem, counts, [&](std::size_t, double x) {
        return static_cast<long double>(problem.f(x)) / test::expected_density(problem, counts, x);
      });
      const auto exact = gmis::exact_moments(gmis::CountsByProposal(counts), table);
      CHECK(exact.mean == Approx(problem.integral).epsilon(1e-9));
      CHECK(exact.variance == Approx(static_cast<double>(oracle.variance)).epsilon(1e-8));

      const auto fractions = gmis::fractions_of(counts);
      long double total = 0.0L;
      for (const auto count : counts) total += count;
      const long double second = test::integral(problem, [&](double x) {
        const long double d = test::expected_density(problem, counts, x) / total;
        return d > 0.0L ? static_cast<long double>(problem.f(x)) * static_cast<long double>(problem.f(x)) / d : 0.0L;
      });
      const long double integral = problem.integral;
      const auto mixture = gmis::exact_moments_of_mixture(fractions, 5, table);
      CHECK(mixture.mean == Approx(problem.integral).epsilon(1e-9));
      CHECK(mixture.variance == Approx(static_cast<double>((second - integral * integral) / 5.0L)).epsilon(1e-8));
    }
    CHECK(gmis::exact_moments(gmis::CountsByProposal(problem.one_each()), table).variance ==
          Approx(exact_variance(gmis::Scheme::N3, table)).epsilon(1e-9));
  }
}

TEST_CASE("semidefinite systems: dependent columns get nothing", "[mis]") {
  // Columns 0 and 2 are the same; the diagonal spans 20 powers of ten.
  const std::vector<double> matrix{4.0, 1e-10, 4.0, 1e-10, 1e-20, 1e-10, 4.0, 1e-10, 4.0};
  const std::vector<double> right{8.0 + 3e-10, 2e-10 + 3e-20, 8.0 + 3e-10};
  const auto x = gmis::solve_semidefinite(matrix, right);
  CHECK((x[0] == 0.0 || x[2] == 0.0));
  CHECK(x[0] + x[2] == Approx(2.0).epsilon(1e-9));
  CHECK(x[1] == Approx(3.0).epsilon(1e-6));
  CHECK(gmis::solve_semidefinite({0.0}, std::vector<double>{0.0}) == std::vector<double>{0.0});
}

TEST_CASE("control variates: coefficients and variances, as defined", "[mis]") {
  for (const four::Problem& problem : problems)
    for (const auto& counts : {problem.one_each(), test::uneven_counts(problem)}) {
      CAPTURE(problem.name, counts);
      const auto table = test::tabulated(problem);
      const auto best = gmis::control_coefficients(counts, table);
      const auto oracle = coefficients_by_definition(problem, counts);
      for (std::size_t k = 0; k < best.size(); ++k) CHECK(best[k] == Approx(oracle[k]).margin(1e-6));

      std::vector<double> other(best);
      for (std::size_t k = 0; k < other.size(); ++k) other[k] += 0.1 * (static_cast<double>(k) - 0.7);
      const auto exact = gmis::exact_moments_controlled(counts, other, table);
      CHECK(exact.mean == Approx(problem.integral).epsilon(1e-9));
      CHECK(exact.variance ==
            Approx(static_cast<double>(variance_by_definition(problem, counts, other))).epsilon(1e-7));

      // Nothing near the solution is better, except that a multiple of n is free: Σ n_k q_k is n ψ.
      const double least = gmis::exact_moments_controlled(counts, best, table).variance;
      const double n3 = gmis::exact_moments(gmis::CountsByProposal(counts), table).variance;
      CHECK(least <= n3);
      for (std::size_t k = 0; k < best.size(); ++k)
        for (const double step : {-0.03, 0.03}) {
          other = best;
          other[k] += step;
          CHECK(gmis::exact_moments_controlled(counts, other, table).variance >= least);
        }
      for (std::size_t k = 0; k < best.size(); ++k) other[k] = best[k] + 0.3 * counts[k];
      CHECK(gmis::exact_moments_controlled(counts, other, table).variance == Approx(least).margin(1e-9 * n3));
    }
  const auto table = test::tabulated(problems[1]);
  const auto best = gmis::control_coefficients(problems[1].one_each(), table);
  CHECK(best[0] == Approx(0.2).epsilon(1e-9));
  CHECK(best[1] == Approx(0.7).epsilon(1e-9));
  CHECK(best[2] == Approx(0.1).epsilon(1e-9));
  CHECK(gmis::exact_moments_controlled(problems[1].one_each(), best, table).variance < 1e-20);
}

// 4 problems × 2 counts × (mean, variance): 16 tests, false-alarm rate 1e-4 in all.
TEST_CASE("control variates: measured means and variances are the exact ones", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(41));
  for (const four::Problem& problem : problems)
    for (const auto& counts : {problem.one_each(), test::uneven_counts(problem)}) {
      CAPTURE(problem.name, counts);
      std::vector<double> beta = gmis::control_coefficients(counts, test::tabulated(problem));
      beta[0] += 0.1;  // not the best ones: the variance of `span` would be zero
      const auto exact = gmis::exact_moments_controlled(counts, beta, test::tabulated(problem));
      CHECK(exact.mean == Approx(problem.integral).epsilon(1e-9));
      CHECK_THAT([&] { return gmis::estimate_controlled(problem.f, problem.proposals, counts, beta, 1, source).mean; },
                 gmis::EstimatesExactly(exact, 20000, 2.0 * level));
    }
}

// Unbiased, and the variance comes down to the optimum: 4 problems × 2 tests of the mean, 2 of the
// stated error.
TEST_CASE("optimal weights: progressive and direct estimates", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(42));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto counts = problem.one_each();
    const auto table = test::tabulated(problem);
    const double n3 = gmis::exact_moments(gmis::CountsByProposal(counts), table).variance;
    const double least =
        gmis::exact_moments_controlled(counts, gmis::control_coefficients(counts, table), table).variance;

    constexpr std::uint64_t rounds = 256;
    std::vector<double> progressive(2000), direct(2000);
    double stated = 0.0, stated_direct = 0.0;
    for (std::size_t i = 0; i < progressive.size(); ++i) {
      const auto p = gmis::estimate_optimal_progressive(problem.f, problem.proposals, counts, rounds, source);
      progressive[i] = p.mean;
      stated += p.standard_error.value() * p.standard_error.value() / static_cast<double>(progressive.size());
      const auto d = gmis::estimate_optimal_direct(problem.f, problem.proposals, counts, rounds, source);
      direct[i] = d.mean;
      stated_direct += d.standard_error.value() * d.standard_error.value() / static_cast<double>(direct.size());
      if (i == 0) {
        CHECK(p.samples == rounds * counts.size());
        CHECK(p.rounds < rounds);
        CHECK(p.density_evaluations == rounds * counts.size() * counts.size());
      }
    }
    const auto p = test::moments_of(progressive), d = test::moments_of(direct);
    CHECK(test::mean_p_value(p, problem.integral) > level);
    if (least < 1e-9 * n3) {  // `span`: the answer itself
      CHECK(p.variance < 1e-18);
      CHECK(d.variance < 1e-18);
      continue;
    }
    // The bias of the direct estimator is below variance/rounds times a constant of the order of N,
    // far below the standard deviation of a run; the test allows a hundredth of that.
    CHECK(test::normal_p_value(std::max(0.0, std::abs(d.mean - problem.integral) - 0.01 * std::sqrt(d.variance)) /
                               d.standard_error) > level);
    const auto interval = test::bootstrap_variance_interval(progressive, level, source);
    CAPTURE(interval.low, interval.high, stated, stated_direct, least / rounds, n3 / rounds);
    CHECK(interval.contains(stated));
    const auto of_direct = test::bootstrap_variance_interval(direct, level, source);
    CAPTURE(of_direct.low, of_direct.high);
    CHECK(of_direct.low < 1.05 * stated_direct);
    CHECK(of_direct.high > 0.95 * stated_direct);
    CHECK(of_direct.high > 0.98 * least / rounds);
    CHECK(of_direct.low < 1.1 * least / rounds);
    CHECK(stated < 1.1 * least / rounds);  // the mean of 2000 unbiased estimates: known to 1 %
  }
}

TEST_CASE("optimal weights: sum to one, and give the controlled estimator", "[mis]") {
  for (const four::Problem& problem : problems) {
    const auto counts = test::uneven_counts(problem);
    const auto beta = gmis::control_coefficients(counts, test::tabulated(problem));
    const double x = 0.61;
    std::vector<double> densities, weights(counts.size());
    for (const auto& proposal : problem.proposals) densities.push_back(proposal.pdf(x));
    gmis::optimal_weights(beta, counts, densities, problem.f(x), weights);
    double sum = 0.0, controlled = problem.f(x), total = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      sum += weights[k];
      controlled -= beta[k] * densities[k];
      total += counts[k] * densities[k];
    }
    CHECK(sum == Approx(1.0).epsilon(1e-12));
    // w_k f/(n_k q_k) = β_k/n_k + (f − Σ β q)/Σ n q, so that one sample of every kind adds up to
    // the controlled estimate.
    for (std::size_t k = 0; k < weights.size(); ++k)
      if (densities[k] > 0.0)
        CHECK(weights[k] * problem.f(x) / (counts[k] * densities[k]) ==
              Approx(beta[k] / counts[k] + controlled / total).epsilon(1e-10));
  }
}

TEST_CASE("control variates: channels, logarithms, pilots and faults", "[mis]") {
  const four::Problem& problem = problems[0];
  const auto counts = problem.one_each();
  gmis::Philox source(gmis_test::seed(43));
  const auto rgb = [&](double x) { return glm::dvec3(problem.f(x), four::span(x), 2.0 * problem.f(x)); };
  const auto estimate = gmis::estimate_optimal_progressive(rgb, problem.proposals, counts, 2000, source);
  for (int c = 0; c < 3; ++c) {
    CAPTURE(c);
    const double truth = c == 2 ? 2.0 : 1.0;
    CHECK(test::normal_p_value((estimate.mean[c] - truth) / estimate.standard_error.value()[c]) > 1e-5);
  }
  CHECK((*estimate.variance)[2] == Approx(4.0 * (*estimate.variance)[0]).epsilon(1e-9));
  const auto direct = gmis::estimate_optimal_direct(rgb, problem.proposals, counts, 2000, source);
  CHECK(test::normal_p_value((direct.mean[0] - 1.0) / (*direct.standard_error)[0]) > 1e-5);

  // A pilot's coefficients serve as well as those of quadrature.
  const gmis::PilotSamples pilot(problem.f, problem.proposals, 300, source);
  const auto beta = gmis::control_coefficients(counts, pilot.problem());
  const auto table = test::tabulated(problem);
  const double least =
      gmis::exact_moments_controlled(counts, gmis::control_coefficients(counts, table), table).variance;
  CHECK(gmis::exact_moments_controlled(counts, beta, table).variance < 1.1 * least);

  const auto broken = [](double x) { return x > 0.0 ? std::nan("") : 1.0; };
  const auto counted = gmis::estimate_optimal_direct(broken, problem.proposals, counts, 100, source);
  CHECK(counted.rejected.non_finite_integrand > 100);
  CHECK(std::isfinite(counted.mean));
  CHECK_THROWS_AS(
      gmis::estimate_optimal_direct(problem.f, problem.proposals, std::vector<std::uint32_t>{1, 1}, 2, source),
      std::invalid_argument);
  CHECK_THROWS_AS(
      gmis::estimate_optimal_direct(problem.f, problem.proposals, std::vector<std::uint32_t>{0, 0, 0}, 2, source),
      std::invalid_argument);
}

TEST_CASE("control variates: channels are as if each was alone, and fits can be merged", "[mis]") {
  const four::Problem& problem = problems[3];
  const auto counts = test::uneven_counts(problem);
  const std::size_t n = counts.size();
  const auto scalar = [&](int c) {
    return [&, c](double x) { return c == 0 ? problem.f(x) : c == 1 ? 3.0 * x * x : std::cos(4.0 * x) - 2.0; };
  };
  const auto colour = [&](double x) { return glm::dvec3(scalar(0)(x), scalar(1)(x), scalar(2)(x)); };
  std::vector<double> beta(3 * n);
  for (std::size_t i = 0; i < beta.size(); ++i) beta[i] = 0.3 * std::sin(1.0 + 2.0 * static_cast<double>(i));
  gmis::Philox a(11);
  const auto controlled = gmis::estimate_controlled(colour, problem.proposals, counts, beta, 20, a);
  const auto direct = gmis::estimate_optimal_direct(colour, problem.proposals, counts, 20, a);
  const auto progressive = gmis::estimate_optimal_progressive(colour, problem.proposals, counts, 20, a);
  for (int c = 0; c < 3; ++c) {
    CAPTURE(c);
    gmis::Philox b(11);
    const auto same = [c](const auto& all, const auto& alone) {
      CHECK(all.mean[c] == Approx(alone.mean).epsilon(1e-9));
      CHECK((*all.variance)[c] == Approx(alone.variance.value()).epsilon(1e-7));
    };
    const auto own = std::span<const double>(beta).subspan(static_cast<std::size_t>(c) * n, n);
    same(controlled, gmis::estimate_controlled(scalar(c), problem.proposals, counts, own, 20, b));
    same(direct, gmis::estimate_optimal_direct(scalar(c), problem.proposals, counts, 20, b));
    same(progressive, gmis::estimate_optimal_progressive(scalar(c), problem.proposals, counts, 20, b));
  }

  gmis::ControlFit<double> whole(3), first(3), second(3);
  gmis::Philox source(12);
  for (int i = 0; i < 40; ++i) {
    const std::array<double, 3> relative{gmis::uniform<double>(source), gmis::uniform<double>(source),
                                         gmis::uniform<double>(source)};
    const std::array<double, 1> value{gmis::uniform<double>(source)};
    whole.add(std::span<const double>(relative), value);
    (i < 15 ? first : second).add(std::span<const double>(relative), value);
  }
  first.merge(second);
  CHECK(first.samples() == 40);
  const auto expected = whole.coefficients(), merged = first.coefficients();
  for (std::size_t k = 0; k < 3; ++k) CHECK(merged[k] == Approx(expected[k]).epsilon(1e-10));
}

// The definition, in long double: least squares of f/ψ by q_k/ψ over all samples, the mean of the
// residuals and its spread between rounds.
TEST_CASE("optimal weights: the direct estimate and its stated error by definition", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto counts = problem.one_each();
    const std::size_t n = counts.size();
    constexpr std::size_t rounds = 5;
    std::vector<double> xs;
    gmis::Philox source(gmis_test::seed(44));
    const auto recorded = [&](double x) {
      xs.push_back(x);
      return problem.f(x);
    };
    const auto estimate = gmis::estimate_optimal_direct(recorded, problem.proposals, counts, rounds, source);
    std::vector<std::vector<long double>> rows(n, std::vector<long double>(n + 1));
    const auto relative = [&](std::size_t k, double x) {
      return static_cast<long double>(n) * static_cast<long double>(problem.proposals[k].pdf(x)) /
             test::expected_density(problem, counts, x);
    };
    const auto value = [&](double x) {
      return static_cast<long double>(n) * static_cast<long double>(problem.f(x)) /
             test::expected_density(problem, counts, x);
    };
    for (const double x : xs)
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) rows[i][j] += relative(i, x) * relative(j, x);
        rows[i][n] += relative(i, x) * value(x);
      }
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t i = 0; i < n; ++i) {
        if (i == p) continue;
        const long double factor = rows[i][p] / rows[p][p];
        for (std::size_t j = p; j <= n; ++j) rows[i][j] -= factor * rows[p][j];
      }
    std::vector<long double> of_round(rounds);
    long double sum_of_beta = 0.0L, mean = 0.0L, squares = 0.0L;
    for (std::size_t k = 0; k < n; ++k) sum_of_beta += rows[k][n] / rows[k][k];
    for (std::size_t s = 0; s < xs.size(); ++s) {
      long double residual = value(xs[s]);
      for (std::size_t k = 0; k < n; ++k) residual -= rows[k][n] / rows[k][k] * relative(k, xs[s]);
      of_round[s / n] += residual / static_cast<long double>(n);
    }
    for (const long double r : of_round) mean += r / static_cast<long double>(rounds);
    for (const long double r : of_round) squares += (r - mean) * (r - mean);
    const long double samples = static_cast<long double>(xs.size());
    CHECK(estimate.mean == Approx(static_cast<double>(sum_of_beta + mean)).epsilon(1e-6));
    const double variance =
        static_cast<double>(squares / (rounds - 1) * samples / (samples - static_cast<long double>(n)));
    CHECK(estimate.variance.value() == Approx(variance).epsilon(1e-4).margin(1e-12));
  }
}

TEST_CASE("semidefinite systems: columns that are almost copies get nothing either", "[mis]") {
  const std::vector<double> matrix{1.0, 1.0, 1.0, 1.0 + 1e-13};
  const auto x = gmis::solve_semidefinite(matrix, std::vector<double>{1.0, 1.0 + 3e-13});
  CHECK((x[0] == 0.0 || x[1] == 0.0));
  CHECK(x[0] + x[1] == Approx(1.0).epsilon(1e-9));
}

TEST_CASE("counted variance: samples that fail contribute zero", "[mis]") {
  // A uniform proposal that makes a half of its samples only, density 1/2: y = 2 with probability
  // 1/2.
  const std::vector<double> values{1.0}, weights{1.0}, densities{0.5};
  const gmis::TabulatedProblem table(values, weights, densities);
  const std::vector<std::uint32_t> counts{2};
  const auto counted = gmis::exact_moments(gmis::CountsByProposal(counts), table);
  CHECK(counted.mean == Approx(1.0));
  CHECK(counted.variance == Approx(0.5));
  const auto mixed = gmis::exact_moments_of_mixture(std::vector<double>{1.0}, 2, table);
  CHECK(mixed.mean == Approx(1.0));
  CHECK(mixed.variance == Approx(0.5));
}
