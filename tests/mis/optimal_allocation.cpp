#include "gmis/mis/methods/optimal_allocation.hpp"

#include <cmath>
#include <vector>

#include "gmis/mis/estimate.hpp"
#include "mis/method_oracles.hpp"
#include "support/catch.hpp"

namespace {

const std::vector<four::Problem> problems = four::problems();

/// (∫ f²/ψ − I²) Σ α c in long double.
double objective(const four::Problem& problem, const std::vector<double>& fractions, const std::vector<double>& costs) {
  const long double second = test::integral(problem, [&](double x) {
    long double psi = 0.0L;
    for (std::size_t k = 0; k < fractions.size(); ++k)
      psi += static_cast<long double>(fractions[k]) * static_cast<long double>(problem.proposals[k].pdf(x));
    const long double f = problem.f(x);
    return psi > 0.0L ? f * f / psi : 0.0L;
  });
  long double cost = 0.0L;
  for (std::size_t k = 0; k < fractions.size(); ++k) cost += static_cast<long double>(fractions[k] * costs[k]);
  const long double integral = problem.integral;
  return static_cast<double>((second - integral * integral) * cost);
}

}  // namespace

TEST_CASE("optimal fractions: no others are better", "[mis]") {
  std::mt19937_64 engine(gmis_test::seed(51));
  for (const four::Problem& problem : problems) {
    const auto table = test::tabulated(problem);
    const std::size_t n = problem.proposals.size();
    for (const bool equal : {true, false}) {
      CAPTURE(problem.name, equal);
      std::vector<double> costs(n, 1.0);
      if (!equal)
        for (std::size_t k = 0; k < n; ++k) costs[k] = 0.5 + static_cast<double>((k * 7) % 4);
      const auto best = gmis::optimal_fractions(table, costs);
      double sum = 0.0;
      for (const double fraction : best) sum += fraction;
      CHECK(sum == Approx(1.0).epsilon(1e-12));
      const double least = objective(problem, best, costs);
      const std::vector<double> uniform(n, 1.0 / static_cast<double>(n));
      const double scale = objective(problem, uniform, costs);
      CHECK(least <= scale * (1.0 + 1e-9));
      // Other points of the simplex, far and near.
      for (int trial = 0; trial < 60; ++trial) {
        std::vector<double> other(n);
        double total = 0.0;
        const double distance = trial % 3 == 0 ? 1.0 : trial % 3 == 1 ? 0.1 : 0.01;
        for (std::size_t k = 0; k < n; ++k) {
          other[k] = best[k] * (1.0 - distance) - distance * std::log(1.0 - gmis::uniform<double>(engine));
          total += other[k];
        }
        for (double& fraction : other) fraction /= total;
        CHECK(objective(problem, other, costs) >= least * (1.0 - 2e-6) - 1e-10 * scale);
      }
    }
  }
  // Where f is a mixture of the proposals, its fractions are the answer, and there is no variance
  // left.
  const auto best = gmis::optimal_fractions(test::tabulated(problems[1]));
  CHECK(best[0] == Approx(0.2).epsilon(1e-4));
  CHECK(best[1] == Approx(0.7).epsilon(1e-4));
  CHECK(best[2] == Approx(0.1).epsilon(1e-4));
  // A defence is kept, and what is left is the best under it.
  const auto safe = gmis::optimal_fractions(test::tabulated(problems[2]), {}, 0.1);
  double sum = 0.0;
  for (const double fraction : safe) {
    CHECK(fraction >= 0.1 - 1e-15);
    sum += fraction;
  }
  CHECK(sum == Approx(1.0).epsilon(1e-9));
  const std::vector<double> alike(4, 1.0);
  const double least = objective(problems[2], safe, alike);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<double> other(4);
    double total = 0.0;
    for (double& part : other) total += part = -std::log(1.0 - gmis::uniform<double>(engine));
    const double distance = trial % 3 == 0 ? 1.0 : trial % 3 == 1 ? 0.1 : 0.01;
    for (std::size_t k = 0; k < 4; ++k) other[k] = safe[k] + distance * (0.1 + 0.6 * other[k] / total - safe[k]);
    CHECK(objective(problems[2], other, alike) >= least * (1.0 - 2e-6));
  }
  CHECK_THROWS_AS(gmis::optimal_fractions(test::tabulated(problems[2]), {}, 0.5), std::invalid_argument);
  CHECK_THROWS_AS(gmis::optimal_fractions(test::tabulated(problems[2]), std::vector<double>{1.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(gmis::optimal_fractions(test::tabulated(problems[2]), std::vector<double>{1.0, 0.0, 1.0, 1.0}),
                  std::invalid_argument);
}

TEST_CASE("optimal fractions: the condition of Karush, Kuhn and Tucker", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto best = gmis::optimal_fractions(test::tabulated(problem));
    std::vector<double> gradient;
    double largest = 0.0;
    for (std::size_t k = 0; k < best.size(); ++k) {
      gradient.push_back(static_cast<double>(test::integral(problem, [&](double x) {
        long double psi = 0.0L;
        for (std::size_t j = 0; j < best.size(); ++j)
          psi += static_cast<long double>(best[j]) * static_cast<long double>(problem.proposals[j].pdf(x));
        const long double ratio = psi > 0.0L ? static_cast<long double>(problem.f(x)) / psi : 0.0L;
        return ratio * ratio * static_cast<long double>(problem.proposals[k].pdf(x));
      })));
      largest = std::max(largest, gradient.back());
    }
    for (std::size_t k = 0; k < best.size(); ++k)
      if (best[k] > 1e-3) CHECK(gradient[k] == Approx(largest).epsilon(2e-3));
  }
}

TEST_CASE("optimal counts: no single exchange is better, and small totals are searched whole", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto table = test::tabulated(problem);
    const std::size_t n = problem.proposals.size();
    const auto variance = [&](const std::vector<std::uint32_t>& counts) {
      return static_cast<double>(test::moments_by_definition(problem, counts, [&](std::size_t, double x) {
                                   return static_cast<long double>(problem.f(x)) /
                                          test::expected_density(problem, counts, x);
                                 }).variance);
    };
    const auto mean_is_right = [&](const std::vector<std::uint32_t>& counts) {
      return std::abs(gmis::exact_moments(gmis::CountsByProposal(counts), table).mean - problem.integral) < 1e-6;
    };
    // All compositions of 6 into N parts, by brute force on the table; the answer must be within 1
    // % of the best.
    const auto answer = gmis::optimal_counts(table, 6);
    double least = 1e300;
    std::vector<std::uint32_t> counts(n);
    const auto search = [&](auto&& self, std::size_t k, std::uint32_t left) -> void {
      if (k + 1 == n) {
        counts[k] = left;
        if (mean_is_right(counts))
          least = std::min(least, gmis::exact_moments(gmis::CountsByProposal(counts), table).variance);
        return;
      }
      for (std::uint32_t c = 0; c <= left; ++c) {
        counts[k] = c;
        self(self, k + 1, left - c);
      }
    };
    search(search, 0, 6);
    CHECK(variance(answer) <= 1.01 * least);

    const auto large = gmis::optimal_counts(table, 50);
    std::uint32_t total = 0;
    for (const auto count : large) total += count;
    CHECK(total == 50);
    const auto fractions = gmis::optimal_fractions(table);
    std::vector<std::uint32_t> rounded(n);
    gmis::apportion<double>(fractions, 50, rounded);
    if (mean_is_right(rounded)) CHECK(variance(large) <= variance(rounded) * (1.0 + 1e-6));
    const double settled = gmis::exact_moments(gmis::CountsByProposal(large), table).variance;
    for (std::size_t from = 0; from < n; ++from)
      for (std::size_t to = 0; to < n; ++to) {
        if (from == to || large[from] == 0) continue;
        std::vector<std::uint32_t> other(large);
        --other[from];
        ++other[to];
        if (mean_is_right(other))
          CHECK(gmis::exact_moments(gmis::CountsByProposal(other), table).variance >= settled * (1.0 - 1e-9));
      }
  }
  CHECK_THROWS_AS(gmis::optimal_counts(test::tabulated(problems[0]), 0), std::invalid_argument);
}

TEST_CASE("inverse variances: the rule, and its ends", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto fractions = gmis::inverse_variance_fractions(test::tabulated(problem));
    std::vector<double> expected(fractions.size());
    double sum = 0.0;
    for (std::size_t k = 0; k < fractions.size(); ++k) {
      std::vector<double> alone(fractions.size());
      alone[k] = 1.0;
      const auto q = [&](double x) { return static_cast<long double>(problem.proposals[k].pdf(x)); };
      const long double missed = test::integral(
          problem, [&](double x) { return q(x) > 0.0L ? 0.0L : std::abs(static_cast<long double>(problem.f(x))); });
      if (missed < 1e-9L) expected[k] = 1.0 / objective(problem, alone, std::vector<double>(alone.size(), 1.0));
      sum += expected[k];
    }
    for (std::size_t k = 0; k < fractions.size(); ++k) CHECK(fractions[k] == Approx(expected[k] / sum).margin(1e-6));
  }
  // All to a proposal without variance, beside one that fails every other time; equal where none
  // covers f alone.
  const std::vector<double> one{1.0}, two{1.0, 1.0};
  CHECK(gmis::inverse_variance_fractions(gmis::TabulatedProblem(one, one, {1.0, 0.5}))[0] == 1.0);
  CHECK(gmis::inverse_variance_fractions(gmis::TabulatedProblem(two, two, {1.0, 0.0, 0.0, 1.0, 0.0, 1.0})) ==
        std::vector<double>(3, 1.0 / 3.0));
  // However many have no variance, they share all samples.
  CHECK(gmis::inverse_variance_fractions(gmis::TabulatedProblem(one, one, {1.0, 1.0, 1.0, 0.5, 1.0})) ==
        std::vector<double>{0.25, 0.25, 0.25, 0.0, 0.25});
}

TEST_CASE("allocation: costs count", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto table = test::tabulated(problem);
    const std::size_t n = problem.proposals.size();
    std::vector<double> costs(n);
    for (std::size_t k = 0; k < n; ++k) costs[k] = k % 2 == 0 ? 9.0 : 1.0;
    const auto plain = gmis::inverse_variance_fractions(table), priced = gmis::inverse_variance_fractions(table, costs);
    double sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) sum += plain[k] / costs[k];
    for (std::size_t k = 0; k < n; ++k) CHECK(priced[k] == Approx(plain[k] / costs[k] / sum).margin(1e-12));

    // All compositions of 6 again, by variance × cost.
    const auto score = [&](const std::vector<std::uint32_t>& counts) {
      double cost = 0.0;
      for (std::size_t k = 0; k < n; ++k) cost += counts[k] * costs[k];
      const auto moments = gmis::exact_moments(gmis::CountsByProposal(counts), table);
      return std::abs(moments.mean - problem.integral) < 1e-6 ? moments.variance * cost : 1e300;
    };
    double least = 1e300;
    std::vector<std::uint32_t> counts(n);
    const auto search = [&](auto&& self, std::size_t k, std::uint32_t left) -> void {
      if (k + 1 == n) {
        counts[k] = left;
        least = std::min(least, score(counts));
        return;
      }
      for (std::uint32_t c = 0; c <= left; ++c) {
        counts[k] = c;
        self(self, k + 1, left - c);
      }
    };
    search(search, 0, 6);
    CHECK(score(gmis::optimal_counts(table, 6, costs)) <= 1.05 * least);
  }
  // Two halves: no fractions or counts that leave out one of them.
  const std::vector<four::Density> halves{four::uniform(0.0, 0.5), four::uniform(0.5, 1.0), four::uniform(0.0, 1.0)};
  const gmis::TabulatedProblem split([](double x) { return x < 0.5 ? 1.0 : 1e-6; }, halves, problems[3].nodes());
  const auto counts = gmis::optimal_counts(split, 2);
  CHECK((counts[2] > 0 || (counts[0] > 0 && counts[1] > 0)));
  CHECK(gmis::inverse_variance_fractions(split)[0] == 0.0);
  const auto defended = gmis::optimal_fractions(split, {}, 0.2);
  for (const double fraction : defended) CHECK(fraction >= 0.2);
}
