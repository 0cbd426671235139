#include <array>
#include <cmath>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/testing/catch.hpp"
#include "mis/oracle_cases.hpp"
#include "mis/proposals.hpp"
#include "mis/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {

using gmis::GroupOrder;
using gmis::Groups;
using gmis::Scheme;

const std::vector<test::Normal> normals{{-3.0, 2.0}, {-1.5, 2.0}, {0.0, 2.0}, {1.5, 2.0}, {3.0, 2.0}, {0.5, 3.0}};
double target(double x) {
  return test::integrand_b(x);
}

/// Mean and variance of one round, in long double by the trapezoidal rule (which converges
/// geometrically for functions that vanish at both ends), written straight from the definition:
/// f(x)/ψ_g(x) with x ~ q_k, independent for each k.
struct Oracle {
  double mean, variance;
};
template <class P>
Oracle by_definition(const P& proposals, const std::vector<std::vector<std::size_t>>& groups) {
  constexpr int points = 6000;
  const long double n = static_cast<long double>(proposals.size());
  long double mean = 0.0L, variance = 0.0L;
  for (const auto& group : groups)
    for (const std::size_t k : group) {
      long double first = 0.0L, second = 0.0L;
      for (int i = 0; i < points; ++i) {
        const double x = -30.0 + 60.0 * i / points;
        long double psi = 0.0L;
        for (const std::size_t j : group) psi += static_cast<long double>(proposals[j].pdf(x));
        psi /= static_cast<long double>(group.size());
        if (psi == 0.0L) continue;
        const long double value = static_cast<long double>(target(x)) / psi;
        first += static_cast<long double>(proposals[k].pdf(x)) * value * 60.0L / points;
        second += static_cast<long double>(proposals[k].pdf(x)) * value * value * 60.0L / points;
      }
      mean += first / n;
      variance += (second - first * first) / (n * n);
    }
  return {static_cast<double>(mean), static_cast<double>(variance)};
}

Groups<> groups_of(const std::vector<std::vector<std::size_t>>& groups, std::size_t proposal_count) {
  std::vector<std::uint32_t> group_of(proposal_count);
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const std::size_t k : groups[g]) group_of[k] = static_cast<std::uint32_t>(g);
  return Groups<>(std::span<const std::uint32_t>(group_of));
}

const std::vector<std::vector<std::vector<std::size_t>>> partitions{
    {{0}, {1}, {2}, {3}, {4}, {5}}, {{0, 3}, {1, 4}, {2, 5}}, {{0, 1, 2}, {3, 4, 5}},
    {{4, 0}, {1, 5, 3, 2}},         {{5}, {0, 1, 2, 3, 4}},   {{0, 1, 2, 3, 4, 5}}};

}  // namespace

TEST_CASE("groups: every proposal is in one, sizes are as even as may be", "[mis]") {
  for (std::size_t n = 1; n <= 20; ++n)
    for (std::size_t size = 1; size <= n; ++size)
      for (const auto order : {GroupOrder::strided, GroupOrder::consecutive}) {
        CAPTURE(n, size);
        const Groups<> groups(n, size, order);
        const Groups<32> fixed(n, size, order);
        CHECK(groups.size() == (n + size - 1) / size);
        std::vector<int> seen(n);
        std::size_t smallest = n, largest = 0, evaluations = 0, last = 0;
        bool ascends = true;
        for (std::size_t g = 0; g < groups.size(); ++g) {
          const auto members = groups.members(g);
          smallest = std::min(smallest, members.size());
          largest = std::max(largest, members.size());
          evaluations += members.size() * members.size();
          CHECK(std::equal(members.begin(), members.end(), fixed.members(g).begin(), fixed.members(g).end()));
          for (const std::uint32_t k : members) {
            ++seen[k];
            if (k < last) ascends = false;
            last = k;
          }
        }
        CHECK(seen == std::vector<int>(n, 1));
        CHECK(largest <= size);
        CHECK(largest - smallest <= 1);
        if (order == GroupOrder::consecutive) CHECK(ascends);
        CHECK(groups.density_evaluations_per_round() == evaluations);
        if (n % size == 0) CHECK(evaluations == n * size);
      }
  const Groups<> strided(6, 2);
  CHECK(std::vector<std::uint32_t>(strided.members(1).begin(), strided.members(1).end()) ==
        std::vector<std::uint32_t>{1, 4});
}

TEST_CASE("partial mixture: groups of one are N1 and one group is N3, to the bit", "[mis]") {
  const auto run = [](const auto& proposals, auto f) {
    const std::size_t n = gmis::as_proposal_set(proposals).size();
    gmis::Philox a(gmis_test::seed(5)), b(gmis_test::seed(5)), c(gmis_test::seed(5)), d(gmis_test::seed(5));
    const auto ones = gmis::estimate_partial(f, proposals, Groups<>(n, 1), 200, a);
    const auto n1 = gmis::estimate<Scheme::N1>(f, proposals, 200, b);
    CHECK(ones.mean == n1.mean);
    CHECK(ones.variance == n1.variance);
    CHECK(ones.density_evaluations == n1.density_evaluations);
    const auto whole = gmis::estimate_partial(f, proposals, Groups<>(n, n), 200, c);
    const auto n3 = gmis::estimate<Scheme::N3>(f, proposals, 200, d);
    CHECK(whole.mean == n3.mean);
    CHECK(whole.variance == n3.variance);
    CHECK(whole.density_evaluations == n3.density_evaluations);
    CHECK(whole.samples == n3.samples);
  };
  run(normals, target);
  run(test::proposals_b, target);
  run(std::make_tuple(test::Normal{-1.0, 2.0}, test::Normal{2.0, 1.5}), target);
  const std::array<test::Normal3, 3> logs{{{{0.5, 0.0, 0.0}, 1.2}, {{-0.5, 0.2, 0.0}, 1.4}, {{0.0, 0.2, 0.4}, 1.3}}};
  const test::Normal3 centre{{0.0, 0.0, 0.0}, 1.0};
  run(logs, [&](const glm::dvec3& x) { return std::exp(centre.log_pdf(x)); });
}

TEST_CASE("partial mixture: exact mean and variance are those of the definition", "[mis]") {
  const gmis::TabulatedProblem problem(target, normals, test::oracle_nodes(64));
  for (const auto& partition : partitions) {
    const Oracle oracle = by_definition(normals, partition);
    const auto exact = exact_moments(groups_of(partition, normals.size()), problem);
    CHECK(exact.mean == Approx(oracle.mean).epsilon(1e-10));
    CHECK(exact.variance == Approx(oracle.variance).epsilon(1e-9));
    CHECK(exact.mean == Approx(1.0).epsilon(1e-10));
  }
  CHECK(exact_moments(Groups<>(6, 1), problem).variance == Approx(exact_variance(Scheme::N1, problem)).epsilon(1e-12));
  CHECK(exact_moments(Groups<>(6, 6), problem).variance == Approx(exact_variance(Scheme::N3, problem)).epsilon(1e-12));
}

// 6 partitions, each a z-test of the mean and a bootstrap interval of the variance: 12 tests,
// false-alarm rate 1e-4 in all. Tails are heavy for groups of one, so bumps take the place of
// normals for the variances.
TEST_CASE("partial mixture: measured means and variances are the exact ones", "[mis]") {
  const double level = test::sidak_level(1e-4, 12);
  std::vector<test::Bump> bumps;
  std::vector<double> breakpoints{0.0};
  for (int k = 0; k < 6; ++k) {
    bumps.push_back({k / 6.0, (k + 1) / 6.0, 0.25});
    breakpoints.push_back((k + 1) / 6.0);
  }
  const auto f = [](double x) { return std::exp(2.0 * x) * (1.0 + std::sin(7.0 * x)); };
  const gmis::TabulatedProblem problem(f, bumps, gmis::composite_gauss_legendre(breakpoints, 1));
  for (const auto& partition : partitions) {
    const Groups<> groups = groups_of(partition, bumps.size());
    gmis::Philox source(gmis_test::seed(31));
    CHECK_THAT([&] { return gmis::estimate_partial(f, bumps, groups, 1, source).mean; },
               gmis::EstimatesExactly(exact_moments(groups, problem), 20000, 2.0 * level));
  }
}

TEST_CASE("partial mixture: each group's mixture must cover f", "[mis]") {
  const std::vector<test::Uniform> halves{{0.0, 0.5}, {0.5, 1.0}, {0.0, 0.5}, {0.5, 1.0}};
  const auto f = [](double x) { return 1.0 + x; };  // ∫ = 3/2: 5/8 below one half, 7/8 above
  const std::array<std::uint32_t, 4> pairs{0, 0, 1, 1}, same{0, 1, 0, 1};
  const Groups<> covering{std::span<const std::uint32_t>(pairs)}, missing{std::span<const std::uint32_t>(same)};
  const std::array<double, 3> breakpoints{0.0, 0.5, 1.0};
  const gmis::TabulatedProblem problem(f, halves, gmis::composite_gauss_legendre(breakpoints, 2));
  CHECK(has_full_support(covering, problem));
  CHECK_FALSE(has_full_support(missing, problem));
  CHECK(exact_moments(covering, problem).mean == Approx(1.5).epsilon(1e-12));
  CHECK(exact_moments(missing, problem).mean == Approx(0.5 * 0.625 + 0.5 * 0.875).epsilon(1e-12));

  const std::vector<double> points{0.1, 0.3, 0.6, 0.9};
  CHECK(gmis::check_coverage(f, halves, covering, points).allows_groups());
  const auto hole = gmis::check_coverage(f, halves, missing, points);
  CHECK_FALSE(hole.allows_groups());
  CHECK(hole.partly_uncovered == 4);
  CHECK(hole.uncovered == 0);
  CHECK(hole.partly_uncovered_example == 0.1);

  // The bias is there in fact, and is the predicted one.
  gmis::Philox source(gmis_test::seed(3));
  const auto estimate = gmis::estimate_partial(f, halves, missing, 4000, source);
  CHECK(test::normal_p_value((estimate.mean - 0.75) / estimate.standard_error.value()) > 1e-4);
  const auto right = gmis::estimate_partial(f, halves, covering, 4000, source);
  CHECK(test::normal_p_value((right.mean - 1.5) / right.standard_error.value()) > 1e-4);
}

TEST_CASE("partial mixture: faults are counted as in every round", "[mis]") {
  struct Either {
    double fault;
    double sample(gmis::Philox& source) const { return gmis::uniform<double>(source); }
    double pdf(double x) const { return x > 0.5 ? fault : 1.0; }
  };
  const std::array<Either, 4> proposals{{{0.0}, {1.0}, {std::nan("")}, {1.0}}};
  gmis::Philox source(gmis_test::seed(4));
  const auto estimate = gmis::estimate_partial([](double) { return 1.0; }, proposals, Groups<>(4, 2), 1000, source);
  // Strided: proposals 0 and 2 are one group, whose four samples in ten above one half see a NaN or
  // a zero.
  CHECK(estimate.rejected.zero_density + estimate.rejected.non_finite_density > 900);
  CHECK(estimate.rejected.zero_density + estimate.rejected.non_finite_density < 1100);
  CHECK(estimate.samples == 4000);
}
