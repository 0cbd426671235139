#include "gmis/mis/methods/resampling.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "gmis/mis/methods/randomised_qmc.hpp"
#include "gmis/testing/catch.hpp"
#include "mis/method_oracles.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

namespace {

using Counts = std::vector<std::uint32_t>;
const std::vector<four::Problem> problems = four::problems();

/// A target that resembles |f| but is not it, and is positive wherever f is not zero.
double target_of(const four::Problem& problem, double x) {
  return problem.breakpoints.front() < 0.0 ? four::normal(x, 0.0, 3.0) + 0.05 * four::logistic(0.0, 1.5).pdf(x)
                                           : 0.3 + std::abs(problem.f(x)) * (1.2 + std::sin(9.0 * x));
}
std::vector<double> target_at_nodes(const four::Problem& problem) {
  std::vector<double> target;
  for (const auto& node : problem.nodes()) target.push_back(target_of(problem, node.x));
  return target;
}

}  // namespace

TEST_CASE("resampling: the exact variance is the double integral, for two candidates", "[mis]") {
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    Counts counts(problem.proposals.size());
    counts[0] = counts[1] = 1;
    // The first two proposals alone: together they cover `highlight` and `waves`, as not every two
    // do.
    const auto table = test::tabulated(problem);
    const auto target = target_at_nodes(problem);
    long double first = 0.0L, second = 0.0L;
    for (std::size_t a = 0; a < table.node_count(); ++a)
      for (std::size_t b = 0; b < table.node_count(); ++b) {
        const auto d = [&](std::size_t i) { return table.densities(0)[i] + table.densities(1)[i]; };
        const double probability =
            table.weights()[a] * table.densities(0)[a] * table.weights()[b] * table.densities(1)[b];
        if (!(probability > 0.0)) continue;
        const double ua = target[a] / d(a), ub = target[b] / d(b);
        const double ya = table.values()[a] / target[a] * (ua + ub), yb = table.values()[b] / target[b] * (ua + ub);
        first += static_cast<long double>(probability * (ua * ya + ub * yb) / (ua + ub));
        second += static_cast<long double>(probability * (ua * ya * ya + ub * yb * yb) / (ua + ub));
      }
    const auto exact = gmis::exact_moments_of_resampling(counts, target, table);
    CHECK(exact.mean == Approx(static_cast<double>(first)).epsilon(1e-9));
    CHECK(exact.variance == Approx(static_cast<double>(second - first * first)).epsilon(1e-7));
  }
}

// 4 problems × 2 counts × (mean, variance).
TEST_CASE("resampling: measured means and variances are the exact ones", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(71));
  for (const four::Problem& problem : problems)
    for (Counts counts : {problem.one_each(), test::uneven_counts(problem)}) {
      for (auto& count : counts) count *= 2;
      CAPTURE(problem.name, counts);
      const auto target = [&](double x) { return target_of(problem, x); };
      const auto exact = gmis::exact_moments_of_resampling(counts, target_at_nodes(problem), test::tabulated(problem));
      CHECK(exact.mean == Approx(problem.integral).epsilon(1e-9));
      CHECK_THAT([&] { return gmis::estimate_resampled(problem.f, target, problem.proposals, counts, 1, source).mean; },
                 gmis::EstimatesExactly(exact, 20000, 2.0 * level));
    }
  const auto once =
      gmis::estimate_resampled(problems[0].f, four::modes, problems[0].proposals, Counts{4, 4, 4}, 50, source);
  CHECK(once.integrand_evaluations == 50);
  CHECK(once.samples == 600);
  CHECK(once.density_evaluations == 1800);
}

// Reservoirs with different targets and numbers of candidates, joined: 4 problems × (mean,
// variance).
TEST_CASE("resampling: joined reservoirs, exact and measured", "[mis]") {
  const double level = test::sidak_level(1e-4, 8);
  gmis::Philox source(gmis_test::seed(72));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    constexpr std::size_t reservoir_count = 3;
    const auto of = [&](std::size_t k, double x) {
      return k == 0   ? target_of(problem, x)
             : k == 1 ? problem.proposals[0].pdf(x) + 0.02 * target_of(problem, x)
                      : std::abs(problem.f(x)) + 1e-3 * target_of(problem, x);
    };
    const auto final_target = [&](double x) { return 0.5 * target_of(problem, x) + std::abs(problem.f(x)); };
    std::vector<Counts> counts(reservoir_count, problem.one_each());
    counts[1] = test::uneven_counts(problem);
    for (auto& count : counts[2]) count *= 3;
    std::vector<long double> totals;
    for (const Counts& list : counts) {
      totals.push_back(0.0L);
      for (const auto count : list) totals.back() += count;
    }
    // v_k = m_k(y_k) p̂(y_k) W_k: E[g(y_k) W_k] = ∫ g, and E[g(y_k) W_k²] as for a single
    // reservoir.
    const auto m = [&](std::size_t k, double x) {
      long double sum = 0.0L;
      for (std::size_t j = 0; j < reservoir_count; ++j) sum += totals[j] * static_cast<long double>(of(j, x));
      return totals[k] * static_cast<long double>(of(k, x)) / sum;
    };
    long double second = 0.0L, sum_v = 0.0L, sum_vhh = 0.0L;
    for (std::size_t k = 0; k < reservoir_count; ++k) {
      const long double v =
          test::integral(problem, [&](double x) { return m(k, x) * static_cast<long double>(final_target(x)); });
      const long double vhh = test::integral(problem, [&](double x) {
        const long double f = problem.f(x);
        return m(k, x) * f * f / static_cast<long double>(final_target(x));
      });
      sum_v += v;
      sum_vhh += vhh;
      second -= v * vhh;
      // Σ n E[u² g/p̂_k²] + (Σ n E u)(Σ n E[u g/p̂_k²]) − Σ n E[u] E[u g/p̂_k²], u = p̂_k/Σ n q,
      // g = m_k² f².
      long double all_u = 0.0L, all_ug = 0.0L;
      for (std::size_t i = 0; i < counts[k].size(); ++i) {
        const auto mean = [&](int power_of_u, bool with_g) {
          return test::integral(problem, [&](double x) {
            const long double q = problem.proposals[i].pdf(x), t = of(k, x), f = problem.f(x);
            if (!(q > 0.0L)) return 0.0L;
            const long double u = t / test::expected_density(problem, counts[k], x);
            const long double g = with_g ? m(k, x) * m(k, x) * f * f / (t * t) : 1.0L;
            return q * (power_of_u == 2 ? u * u : u) * g;
          });
        };
        const long double n = counts[k][i], u = mean(1, false), ug = mean(1, true);
        second += n * mean(2, true) - n * u * ug;
        all_u += n * u;
        all_ug += n * ug;
      }
      second += all_u * all_ug;
    }
    second += sum_v * sum_vhh;
    const double exact = static_cast<double>(second - static_cast<long double>(problem.integral * problem.integral));

    const auto set = gmis::as_proposal_set(problem.proposals);
    gmis::CountedWorkspace<std::remove_cvref_t<decltype(set)>> workspace;
    std::vector<double> rounds(20000);
    for (double& value : rounds) {
      std::vector<gmis::Reservoir<double>> reservoirs;
      gmis::RoundCounts cost;
      for (std::size_t k = 0; k < reservoir_count; ++k)
        reservoirs.push_back(
            gmis::resample([&](double x) { return of(k, x); }, set, counts[k], source, workspace, cost));
      const auto joined =
          gmis::join_reservoirs(std::span<const gmis::Reservoir<double>>(reservoirs), of, final_target, source);
      if (static_cast<long double>(joined.sample_count()) != totals[0] + totals[1] + totals[2])
        FAIL("samples are lost");
      value = joined.sample() ? problem.f(*joined.sample()) * joined.contribution_weight() : 0.0;
    }
    CHECK(test::mean_p_value(test::moments_of(rounds), problem.integral) > level);
    const auto interval = test::bootstrap_variance_interval(rounds, level, source);
    CAPTURE(interval.low, interval.high, exact);
    CHECK(interval.contains(exact));
  }
}

TEST_CASE("resampling: candidates with a target that is no target are counted", "[mis]") {
  gmis::Philox source(gmis_test::seed(75));
  const std::vector<test::Uniform> proposals{{0.0, 1.0}, {0.0, 1.0}};
  const auto one = [](double) { return 1.0; };
  for (const double fault : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    CAPTURE(fault);
    std::uint64_t faults = 0;
    const auto target = [&](double x) { return x < 0.25 ? (++faults, fault) : 1.0; };
    const auto estimate = gmis::estimate_resampled(one, target, proposals, Counts{3, 1}, 500, source);
    CHECK(faults > 0);
    CHECK(estimate.rejected == gmis::Rejected{0, 0, faults, 0});
    // They count as zero: Σ w of a round is the share of its other candidates.
    CHECK(estimate.mean == Approx((2000.0 - static_cast<double>(faults)) / 2000.0).epsilon(1e-12));
  }
}

TEST_CASE("reservoirs: weights that are no weights, and nothing at all", "[mis]") {
  gmis::Philox source(gmis_test::seed(73));
  gmis::Reservoir<int> reservoir;
  reservoir.finish(1.0, 0.0);
  CHECK_FALSE(reservoir.sample().has_value());
  CHECK(reservoir.contribution_weight() == 0.0);
  for (const double weight : {std::nan(""), -1.0, std::numeric_limits<double>::infinity()})
    CHECK_FALSE(reservoir.add(1, weight, source));
  CHECK(reservoir.rejected() == 3);
  CHECK_FALSE(reservoir.add(2, 0.0, source));
  CHECK(reservoir.add(3, 1e-300, source));
  CHECK(reservoir.sample() == 3);
  // Chosen in proportion to their weights: a binomial count, false-alarm rate 1e-5.
  int chosen = 0;
  constexpr int trials = 20000;
  for (int i = 0; i < trials; ++i) {
    gmis::Reservoir<int> three;
    (void)three.add(0, 1.0, source);
    (void)three.add(1, 3.0, source);
    (void)three.add(2, 4.0, source);
    chosen += *three.sample() == 1 ? 1 : 0;
  }
  const double p = 3.0 / 8.0;
  CHECK(test::normal_p_value((chosen - trials * p) / std::sqrt(trials * p * (1.0 - p))) > 1e-5);
}

TEST_CASE("scrambled points: strata, elementary intervals, uniformity", "[mis]") {
  gmis::ScrambledSobol points(gmis_test::seed(74));
  points.start_round(3);
  std::vector<std::vector<std::uint64_t>> drawn;
  for (std::uint32_t i = 0; i < 256; ++i) {
    points.start_sample(7, i);
    drawn.emplace_back();
    for (std::size_t d = 0; d < gmis::ScrambledSobol::dimensions + 2; ++d) drawn.back().push_back(points());
  }
  // One point in each of the first 2^m strata of every dimension, for every m.
  for (std::size_t d = 0; d < gmis::ScrambledSobol::dimensions; ++d)
    for (unsigned m = 0; m <= 8; ++m) {
      std::set<std::uint64_t> strata;
      for (std::size_t i = 0; i < (std::size_t{1} << m); ++i) strata.insert(m == 0 ? 0 : drawn[i][d] >> (64 - m));
      CHECK(strata.size() == std::size_t{1} << m);
    }
  // The first two dimensions are a (0, 8, 2)-net: one point in each of the 256 boxes of every
  // shape.
  for (unsigned a = 0; a <= 8; ++a) {
    std::set<std::uint64_t> boxes;
    for (const auto& point : drawn)
      boxes.insert(((a == 0 ? 0 : point[0] >> (64 - a)) << 8U) | (a == 8 ? 0 : point[1] >> (56 + a)));
    CHECK(boxes.size() == 256);
  }
  // Another round and another stream are other points; the same ones are the same.
  points.start_sample(7, 5);
  CHECK(points() == drawn[5][0]);
  points.start_sample(8, 5);
  CHECK(points() != drawn[5][0]);
  points.start_round(4);
  points.start_sample(7, 5);
  CHECK(points() != drawn[5][0]);
  // A fixed point is uniform over randomisations (mean and second moment, 1e-5 each), beyond the
  // last dimension too.
  for (const std::size_t dimension : {std::size_t{0}, std::size_t{4}, std::size_t{11}}) {
    std::vector<double> values(4000), squares(4000);
    for (std::size_t r = 0; r < values.size(); ++r) {
      points.start_round(r);
      points.start_sample(1, 77);
      for (std::size_t d = 0; d < dimension; ++d) (void)points();
      values[r] = gmis::uniform<double>(points);
      squares[r] = values[r] * values[r];
    }
    CHECK(test::mean_p_value(test::moments_of(values), 0.5) > 1e-5);
    CHECK(test::mean_p_value(test::moments_of(squares), 1.0 / 3.0) > 1e-5);
  }
}

TEST_CASE("points of Sobol': property A", "[mis]") {
  // The first 2^10 points have one in each of the 2^10 parts that halve every dimension [Sobol'
  // 1976; Joe, Kuo 2008].
  std::set<std::uint32_t> parts;
  for (std::uint32_t i = 0; i < 1024; ++i) {
    std::uint32_t part = 0;
    for (std::size_t d = 0; d < gmis::ScrambledSobol::dimensions; ++d)
      part = part << 1U | gmis::ScrambledSobol::coordinate(d, i) >> 31U;
    parts.insert(part);
  }
  CHECK(parts.size() == 1024);
  // The binary digits that point 2^j begins with are the direction numbers v_j = m_j/2^j, from
  // which the recurrence follows: those of dimensions 4 and 10, as Joe and Kuo publish them.
  const auto first = [](std::size_t d, std::uint32_t j) {
    return gmis::ScrambledSobol::coordinate(d, 1U << (j - 1)) >> (32 - j);
  };
  CHECK(std::array{first(3, 1), first(3, 2), first(3, 3)} == std::array<std::uint32_t, 3>{1, 3, 1});
  CHECK(std::array{first(9, 1), first(9, 2), first(9, 3), first(9, 4), first(9, 5)} ==
        std::array<std::uint32_t, 5>{1, 1, 7, 11, 19});
  // m_k = 2 a_1 m_{k−1} ⊕ … ⊕ 2^s m_{k−s} ⊕ m_{k−s}: x³ + x + 1 and x⁵ + x³ + x² + x + 1.
  for (std::uint32_t k = 4; k <= 20; ++k)
    CHECK(first(3, k) == ((first(3, k - 2) << 2U) ^ (first(3, k - 3) << 3U) ^ first(3, k - 3)));
  for (std::uint32_t k = 6; k <= 20; ++k)
    CHECK(first(9, k) == ((first(9, k - 2) << 2U) ^ (first(9, k - 3) << 3U) ^ (first(9, k - 4) << 4U) ^
                          (first(9, k - 5) << 5U) ^ first(9, k - 5)));
}

namespace {

/// In one dimension 2^m scrambled points are one uniform point in each of 2^m equal parts,
/// independently: the variance is the mean variance within parts. All samplers here invert their
/// distribution.
double stratified_variance(const four::Problem& problem, std::uint32_t per_proposal) {
  long double variance = 0.0L;
  const Counts counts(problem.proposals.size(), per_proposal);
  struct Fixed {
    double u;
    using result_type = std::uint64_t;
    static constexpr result_type min() { return 0; }
    static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
    result_type operator()() const { return static_cast<std::uint64_t>(u * 0x1p53) << 11U; }
  };
  for (const four::Density& q : problem.proposals) {
    std::vector<double> cuts{problem.breakpoints.front()};
    for (std::uint32_t i = 1; i < per_proposal; ++i) {
      Fixed fixed{static_cast<double>(i) / per_proposal};
      cuts.push_back(q.sample(fixed));
    }
    cuts.push_back(problem.breakpoints.back());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      std::vector<double> places{cuts[i]};
      for (const double place : problem.breakpoints)
        if (place > cuts[i] && place < cuts[i + 1]) places.push_back(place);
      places.push_back(cuts[i + 1]);
      const auto contribution = [&](double x) {
        return static_cast<long double>(problem.f(x)) / test::expected_density(problem, counts, x);
      };
      const auto mean_of = [&](auto g) {
        return per_proposal * test::integral_over(places, [&](double x) {
                 const long double density = q.pdf(x);
                 return density > 0.0L ? density * g(x) : 0.0L;
               });
      };
      const long double mean = mean_of(contribution);
      variance += mean_of([&](double x) { return (contribution(x) - mean) * (contribution(x) - mean); });
    }
  }
  return static_cast<double>(variance);
}

}  // namespace

// 4 problems × 2 sizes × (mean, variance, mean of all rounds together).
TEST_CASE("randomised quasi-Monte Carlo: unbiased, with the variance of strata", "[mis]") {
  const double level = test::sidak_level(1e-4, 24);
  gmis::Philox source(gmis_test::seed(75));
  for (const four::Problem& problem : problems)
    for (const std::uint32_t per_proposal : {1U, 8U}) {
      CAPTURE(problem.name, per_proposal);
      const Counts counts(problem.proposals.size(), per_proposal);
      gmis::ScrambledSobol points(gmis_test::seed(76 + per_proposal));
      std::vector<double> rounds(10000);
      for (std::size_t r = 0; r < rounds.size(); ++r) {
        gmis::ScrambledSobol own(gmis_test::seed(1000 + r));
        rounds[r] = gmis::estimate_rqmc(problem.f, problem.proposals, counts, 1, own).mean;
      }
      const double exact = stratified_variance(problem, per_proposal);
      CHECK(test::mean_p_value(test::moments_of(rounds), problem.integral) > level);
      const auto interval = test::bootstrap_variance_interval(rounds, level, source);
      CAPTURE(interval.low, interval.high, exact);
      CHECK(interval.contains(exact));
      const auto together = gmis::estimate_rqmc(problem.f, problem.proposals, counts, 4000, points);
      CHECK(together.variance.value() == Approx(exact).epsilon(0.25));
      CHECK(test::normal_p_value((together.mean - problem.integral) / together.standard_error.value()) > level);
    }
}

TEST_CASE("randomised quasi-Monte Carlo: the rate", "[mis]") {
  const four::Problem& problem = problems[0];
  gmis::ScrambledSobol points(gmis_test::seed(77));
  const auto variance = [&](std::uint32_t per_proposal) {
    return gmis::estimate_rqmc(problem.f, problem.proposals, Counts(3, per_proposal), 200, points).variance.value();
  };
  // Independent points would have 1/16 of the variance; these are at 1/490 here, and at 1/4096
  // (n^-3) in the end.
  CHECK(variance(256) < 5e-3 * variance(16));
}
