#include "gmis/mis/heretical_mixture.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis/estimate.hpp"
#include "gmis/mis/partial_mixture.hpp"
#include "mis/method_oracles.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

namespace {

const std::vector<four::Problem> problems = four::problems();

/// Proposals over `cells` numbers, cut out of the densities of a problem; all outcomes of a round can be listed.
struct Discrete {
  std::vector<double> probability;
  std::size_t sample(gmis::UniformSource auto& source) const {
    double u = gmis::uniform<double>(source);
    std::size_t i = 0;
    while (i + 1 < probability.size() && u >= probability[i]) u -= probability[i++];
    return i;
  }
  double pdf(std::size_t i) const { return probability[i]; }
};
struct Finite {
  std::vector<Discrete> proposals;
  std::vector<double> f;
};
constexpr std::size_t cells = 5;
Finite finite_of(const four::Problem& problem, std::size_t proposal_count) {
  Finite result;
  const double low = problem.breakpoints.front() < 0.0 ? -4.5 : 0.0, high = low < 0.0 ? 4.5 : 1.0;
  const auto place = [&](std::size_t i) { return low + (high - low) * (static_cast<double>(i) + 0.37) / cells; };
  for (std::size_t k = 0; k < proposal_count; ++k) {
    Discrete proposal;
    double sum = 0.0;
    for (std::size_t i = 0; i < cells; ++i) {
      // A part of its own for the copies of a proposal, so that no two densities are equal; none is zero.
      const double own = 0.02 + 0.01 * std::sin(3.0 * static_cast<double>(k) + 2.0 * static_cast<double>(i));
      proposal.probability.push_back(problem.proposals[k % problem.proposals.size()].pdf(place(i)) + own);
      sum += proposal.probability.back();
    }
    for (double& p : proposal.probability) p /= sum;
    result.proposals.push_back(proposal);
  }
  for (std::size_t i = 0; i < cells; ++i) result.f.push_back(problem.f(place(i)));
  return result;
}

/// The estimate for samples x, by the definition of the groups.
long double estimate_of(const Finite& problem, const std::vector<std::size_t>& x, std::size_t group_size) {
  const std::size_t n = x.size(), groups = (n + group_size - 1) / group_size;
  const auto q = [&](std::size_t k, std::size_t i) { return static_cast<long double>(problem.proposals[k].pdf(i)); };
  std::vector<bool> is_taken(n);
  long double sum = 0.0L;
  for (std::size_t group = 0; group < groups; ++group) {
    const std::size_t size = n / groups + (group < n % groups ? 1 : 0);
    std::vector<std::size_t> members;
    long double largest = -1.0L;
    for (std::size_t k = 0; k < n; ++k) {
      const long double weight = std::abs(static_cast<long double>(problem.f[x[k]])) / q(k, x[k]);
      if (is_taken[k] || weight <= largest) continue;
      largest = weight;
      members.assign(1, k);
    }
    is_taken[members[0]] = true;
    while (members.size() < size) {
      std::size_t best = n;
      for (std::size_t k = 0; k < n; ++k)
        if (!is_taken[k] && (best == n || q(k, x[members[0]]) > q(best, x[members[0]]))) best = k;
      is_taken[best] = true;
      members.push_back(best);
    }
    for (const std::size_t k : members) {
      long double mixture = 0.0L;
      for (const std::size_t j : members) mixture += q(j, x[k]) / static_cast<long double>(size);
      sum += static_cast<long double>(problem.f[x[k]]) / mixture / static_cast<long double>(n);
    }
  }
  return sum;
}

/// A normal density without logarithms.
struct Plain {
  test::Normal3 normal;
  glm::dvec3 sample(gmis::UniformSource auto& source) const { return normal.sample(source); }
  double pdf(const glm::dvec3& x) const { return std::exp(normal.log_pdf(x)); }
};

}  // namespace

// 4 problems × 2 sets × (mean, variance); the exact ones are sums over all outcomes of a round.
TEST_CASE("heretical MIS: mean and variance by all outcomes", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(97));
  for (const four::Problem& of : problems)
    for (const std::size_t n : {std::size_t{4}, std::size_t{5}}) {
      constexpr std::size_t size = 2;
      CAPTURE(of.name, n);
      const Finite problem = finite_of(of, n);
      long double first = 0.0L, second = 0.0L, total = 0.0L;
      std::vector<std::size_t> x(n);
      const auto all = [&](auto&& self, std::size_t k, long double probability) -> void {
        if (k == n) {
          const long double estimate = estimate_of(problem, x, size);
          total += probability;
          first += probability * estimate;
          second += probability * estimate * estimate;
          return;
        }
        for (x[k] = 0; x[k] < cells; ++x[k])
          self(self, k + 1, probability * static_cast<long double>(problem.proposals[k].pdf(x[k])));
      };
      all(all, 0, 1.0L);
      CHECK(static_cast<double>(total) == Approx(1.0));
      long double truth = 0.0L;
      bool is_positive = true;
      for (const double value : problem.f) {
        truth += static_cast<long double>(value);
        is_positive = is_positive && value >= 0.0;
      }
      CHECK(first != Approx(static_cast<double>(truth)).epsilon(1e-6));
      if (is_positive) CHECK(first < truth);
      const auto f = [&](std::size_t i) { return problem.f[i]; };
      std::vector<double> rounds(20000);
      for (double& value : rounds) value = gmis::estimate_heretical(f, problem.proposals, size, 1, source).mean;
      CHECK(test::mean_p_value(test::moments_of(rounds), static_cast<double>(first)) > level);
      const auto interval = test::bootstrap_variance_interval(rounds, level, source);
      CAPTURE(interval.low, interval.high, first, second);
      CHECK(interval.contains(static_cast<double>(second - first * first)));
    }
}

TEST_CASE("heretical MIS: between N1 and N3, with a bias that is the price", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto run = [&](std::size_t size) {
      gmis::Philox source(gmis_test::seed(98));
      return gmis::estimate_heretical(problem.f, problem.proposals, size, 50, source);
    };
    const auto partial = [&](std::size_t size) {
      gmis::Philox source(gmis_test::seed(98));
      return gmis::estimate_partial(problem.f, problem.proposals, gmis::Groups<>(problem.proposals.size(), size), 50,
                                    source);
    };
    const std::size_t n = problem.proposals.size();
    CHECK(run(1).mean == Approx(partial(1).mean).epsilon(1e-12));
    CHECK(run(n).mean == Approx(partial(n).mean).epsilon(1e-12));
    CHECK(run(1).density_evaluations == 50 * n);
    CHECK(run(n).density_evaluations == 50 * n * n);
    CHECK(run(2).integrand_evaluations == 50 * n);
  }
  // Six proposals in pairs: 6 own densities, 5 + 3 + 1 at the leaders, 3 at the others.
  const four::Problem& six = problems[3];
  gmis::Philox source(gmis_test::seed(99));
  CHECK(gmis::estimate_heretical([](double) { return 1.0; }, six.proposals, 2, 10, source).density_evaluations == 180);
}

TEST_CASE("heretical MIS: logarithms, failures, channels and faults", "[mis]") {
  gmis::Philox a(3), b(3);
  const std::array<test::Normal3, 4> logs{
      {{{0.5, 0.0, 0.0}, 1.2}, {{-0.5, 0.2, 0.0}, 1.4}, {{0.0, 0.2, 0.4}, 1.3}, {{0.1, 0.2, 0.9}, 1.1}}};
  std::vector<Plain> plain;
  for (const auto& q : logs) plain.push_back({q});
  const auto f = [](const glm::dvec3& x) { return std::exp(-glm::dot(x, x)); };
  CHECK(gmis::estimate_heretical(f, logs, 2, 200, a).mean ==
        Approx(gmis::estimate_heretical(f, plain, 2, 200, b).mean).epsilon(1e-9));
  const auto rgb = [&](const glm::dvec3& x) { return glm::dvec3(f(x), 2.0 * f(x), 0.0); };
  gmis::Philox c(3);
  const auto colour = gmis::estimate_heretical(rgb, logs, 2, 200, c);
  CHECK(colour.mean.y == Approx(2.0 * colour.mean.x).epsilon(1e-12));
  CHECK(colour.mean.z == 0.0);
  const auto broken = [](const glm::dvec3& x) { return x.x > 0.0 ? std::nan("") : 1.0; };
  const auto counted = gmis::estimate_heretical(broken, logs, 2, 50, c);
  CHECK(counted.rejected.non_finite_integrand > 50);
  CHECK(std::isfinite(counted.mean));
  CHECK_THROWS_AS(gmis::estimate_heretical(f, logs, 0, 5, c), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_heretical(f, logs, 5, 5, c), std::invalid_argument);
  CHECK_THROWS_AS(gmis::estimate_heretical(f, logs, 2, 0, c), std::invalid_argument);
}
