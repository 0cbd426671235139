#include "gmis/mis/methods/adaptive_mis.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gmis/mis/diagnostics/best_scheme.hpp"
#include "gmis/mis/diagnostics/counted_variance.hpp"
#include "gmis/mis/methods/best_groups.hpp"
#include "gmis/mis/methods/population.hpp"
#include "gmis/mis/methods/self_normalised.hpp"
#include "gmis/mis/partial_mixture.hpp"
#include "mis/method_oracles.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"

namespace {

using Counts = std::vector<std::uint32_t>;
const std::vector<four::Problem> problems = four::problems();

double positive_target(const four::Problem& problem, double x) {
  return problem.f == four::waves ? 5.0 + problem.f(x) : 3.0 * problem.f(x);
}

}  // namespace

// 4 problems × (2 means, normaliser): 12 z-tests; covariances have fixed tolerances.
TEST_CASE("self-normalised: means, stated covariance and effective sample size", "[mis]") {
  const double level = test::sidak_level(1e-4, 12);
  gmis::Philox source(gmis_test::seed(91));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto counts = test::uneven_counts(problem);
    const auto target = [&](double x) { return positive_target(problem, x); };
    const auto h = [](double x) { return std::array<double, 2>{x, std::cos(x)}; };
    const auto pi = [&](double x) { return static_cast<long double>(target(x)); };
    const long double z = test::integral(problem, pi);
    std::array<long double, 2> mu;
    for (std::size_t i = 0; i < 2; ++i)
      mu[i] = test::integral(problem, [&](double x) { return pi(x) * static_cast<long double>(h(x)[i]); }) / z;
    // The covariance of one round, to first order: Σ n_k Cov_k of π (h − μ)/(Z Σ n q).
    const auto covariance = [&](std::size_t i, std::size_t j) {
      long double sum = 0.0L;
      for (std::size_t k = 0; k < counts.size(); ++k) {
        const auto q = [&](double x) { return static_cast<long double>(problem.proposals[k].pdf(x)); };
        const auto y = [&](std::size_t c, double x) {
          return pi(x) * (static_cast<long double>(h(x)[c]) - mu[c]) / (z * test::expected_density(problem, counts, x));
        };
        const auto mean = [&](auto g) {
          return test::integral(problem, [&](double x) { return q(x) > 0.0L ? q(x) * g(x) : 0.0L; });
        };
        sum += counts[k] * (mean([&](double x) { return y(i, x) * y(j, x); }) -
                            mean([&](double x) { return y(i, x); }) * mean([&](double x) { return y(j, x); }));
      }
      return sum;
    };
    const gmis::TabulatedProblem table(target, problem.proposals, problem.nodes());
    constexpr std::uint64_t rounds = 40000;
    const auto estimate = gmis::estimate_self_normalised(target, h, problem.proposals, counts, rounds, source);
    CHECK(test::normal_p_value((estimate.normaliser - static_cast<double>(z)) / estimate.normaliser_error.value()) >
          level);
    CHECK(
        estimate.normaliser_error.value() ==
        Approx(std::sqrt(gmis::exact_moments(gmis::CountsByProposal(counts), table).variance / rounds)).epsilon(0.06));
    for (std::size_t i = 0; i < 2; ++i) {
      const double exact_error = std::sqrt(static_cast<double>(covariance(i, i)) / rounds);
      CHECK(test::normal_p_value((estimate.mean[i] - static_cast<double>(mu[i])) / exact_error) > level);
      CHECK(estimate.standard_error(i).value() == Approx(exact_error).epsilon(0.06));
    }
    CHECK((*estimate.covariance)[0][1] * rounds ==
          Approx(static_cast<double>(covariance(0, 1)))
              .margin(0.06 * std::sqrt(static_cast<double>(covariance(0, 0) * covariance(1, 1)))));
    // (E w)²/E w² over the samples of a round, which weighs proposals by their counts.
    const long double n = [&] {
      long double total = 0.0L;
      for (const auto count : counts) total += count;
      return total;
    }();
    const long double squares =
        test::integral(problem, [&](double x) { return pi(x) * pi(x) / test::expected_density(problem, counts, x); });
    CHECK(estimate.effective_sample_size == Approx(static_cast<double>(z * z / squares) * rounds).epsilon(0.05));
    CHECK(estimate.effective_sample_size <= static_cast<double>(n) * rounds);
    CHECK(estimate.samples == static_cast<std::uint64_t>(n) * rounds);
  }
}

TEST_CASE("self-normalised: log targets, single rounds, faults", "[mis]") {
  gmis::Philox source(gmis_test::seed(92));
  const std::array<test::Normal3, 2> proposals{{{{0.5, 0.0, 0.0}, 1.2}, {{-0.5, 0.2, 0.0}, 1.4}}};
  // Densities and target about e^-2000: out of the range of double, where their ratio is not.
  struct Far : test::Normal3 {
    double log_pdf(const glm::dvec3& x) const { return test::Normal3::log_pdf(x) - 2000.0; }
  };
  const std::array<Far, 2> far{{{{{0.5, 0.0, 0.0}, 1.2}}, {{{-0.5, 0.2, 0.0}, 1.4}}}};
  const Far posterior{{{0.2, -0.1, 0.3}, 0.9}};
  const auto target = [&](const glm::dvec3& x) { return gmis::LogValue<double>{posterior.log_pdf(x) + 5.0}; };
  const auto h = [](const glm::dvec3& x) { return std::array<double, 3>{x.x, x.y, x.z}; };
  const auto estimate = gmis::estimate_self_normalised(target, h, far, Counts{2, 2}, 5000, source);
  CHECK(test::normal_p_value((estimate.normaliser - std::exp(5.0)) / estimate.normaliser_error.value()) > 1e-5);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(test::normal_p_value((estimate.mean[i] - std::array{0.2, -0.1, 0.3}[i]) /
                               estimate.standard_error(i).value()) > 1e-5);
  const auto one = gmis::estimate_self_normalised(target, h, far, Counts{2, 2}, 1, source);
  CHECK_FALSE(one.covariance.has_value());
  CHECK_FALSE(one.standard_error(0).has_value());
  const auto broken = [](const glm::dvec3& x) { return x.x > 0.0 ? std::nan("") : 1.0; };
  const auto counted = gmis::estimate_self_normalised(broken, h, proposals, Counts{1, 1}, 100, source);
  CHECK(counted.rejected.non_finite_integrand > 20);
  CHECK(std::isfinite(counted.mean[0]));
  const auto h_broken = [](const glm::dvec3& x) { return std::array<double, 1>{x.x > 0.0 ? std::nan("") : 1.0}; };
  const auto left_out = gmis::estimate_self_normalised(target, h_broken, far, Counts{1, 1}, 100, source);
  CHECK(left_out.rejected.non_finite_integrand > 20);
  CHECK(left_out.mean[0] == Approx(1.0));
}

// 4 problems × (unbiased, stated error) × 2 relocations; and without moves it is N3.
TEST_CASE("population Monte Carlo: unbiased with an honest error", "[mis]") {
  const double level = test::sidak_level(1e-4, 16);
  gmis::Philox source(gmis_test::seed(93));
  for (const four::Problem& problem : problems)
    for (const auto relocation : {gmis::Relocation::local, gmis::Relocation::global}) {
      CAPTURE(problem.name, static_cast<int>(relocation));
      const auto move = [](const four::Density& q, double x) { return four::logistic(x, q.b); };
      std::vector<double> estimates(3000);
      double stated = 0.0;
      for (double& value : estimates) {
        std::vector<four::Density> population;
        const bool is_unit = problem.breakpoints.front() >= 0.0;
        for (int k = 0; k < 4; ++k)
          population.push_back(is_unit ? four::logistic(0.1 + 0.3 * k, 0.25) : four::logistic(-6.0 + 4.0 * k, 1.5));
        const auto inside = [&](double x) { return !is_unit || (x >= 0.0 && x < 1.0) ? problem.f(x) : 0.0; };
        const auto result = gmis::estimate_population(inside, population, 4, 6, move, source, relocation);
        value = result.mean;
        stated += result.standard_error.value() * result.standard_error.value() / static_cast<double>(estimates.size());
      }
      CHECK(test::mean_p_value(test::moments_of(estimates), problem.integral) > level);
      const auto interval = test::bootstrap_variance_interval(estimates, level, source);
      CAPTURE(interval.low, interval.high, stated);
      // `stated` is a mean of 3000 unbiased estimates of 5 degrees of freedom: known to 2 %, so 8 %
      // are four errors.
      CHECK(interval.low < 1.08 * stated);
      CHECK(interval.high > 0.92 * stated);
    }
  std::vector<four::Density> fixed = problems[0].proposals;
  const auto table = test::tabulated(problems[0]);
  const auto stay = [](const four::Density& q, double) { return q; };
  const auto estimate = gmis::estimate_population(problems[0].f, fixed, 1, 40000, stay, source);
  CHECK(estimate.variance.value() == Approx(exact_variance(gmis::Scheme::N3, table)).epsilon(0.1));
  // Moves pay: proposals that all start in the wrong place find f.
  std::vector<four::Density> lost(6, four::logistic(9.0, 1.0));
  const auto move = [](const four::Density& q, double x) { return four::logistic(x, q.b); };
  (void)gmis::estimate_population(problems[0].f, lost, 20, 30, move, source, gmis::Relocation::global);
  CHECK(std::all_of(lost.begin(), lost.end(), [](const four::Density& q) { return std::abs(q.a) < 6.0; }));
}

TEST_CASE("population Monte Carlo: who moves where", "[mis]") {
  gmis::Philox source(gmis_test::seed(93));
  const auto move = [](const four::Density& q, double x) { return four::logistic(x, q.b); };
  // Far apart: a proposal that moves to its own samples stays where it is; all move to one place
  // otherwise.
  for (const auto relocation : {gmis::Relocation::local, gmis::Relocation::global}) {
    std::vector<four::Density> population{four::logistic(-40.0, 0.1), four::logistic(40.0, 0.1),
                                          four::logistic(0.0, 0.1)};
    const auto before = population;
    const auto f = [](double x) { return x > 20.0 ? 1.0 : 1e-12; };
    (void)gmis::estimate_population(f, population, 3, 1, move, source, relocation);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(population[k].a != before[k].a);
      CHECK(std::abs(population[k].a - (relocation == gmis::Relocation::local ? before[k].a : 40.0)) < 8.0);
    }
  }
  // In proportion to |f|, which is not zero in one tenth alone.
  std::vector<four::Density> unit{four::uniform(0.0, 1.0)};
  const auto f = [](double x) { return x < 0.1 ? -1.0 : 0.0; };
  const auto to = [](const four::Density&, double x) { return four::uniform(x, x + 1.0); };
  (void)gmis::estimate_population(f, unit, 400, 1, to, source);  // none of 400 falls there in one run of 10^18
  CHECK(unit[0].a < 0.1);
  // And to |f/ψ|: ψ is 3/2 below one half and 1/2 above, where only the first makes samples, half
  // of its own. Then it moves there in 2 of 2 + 2/3: in 3/8 of all runs. False-alarm rate 1e-5.
  int above = 0;
  constexpr int runs = 20000;
  for (int i = 0; i < runs; ++i) {
    std::vector<four::Density> pair{four::uniform(0.0, 1.0), four::uniform(0.0, 0.5)};
    (void)gmis::estimate_population([](double) { return 1.0; }, pair, 1, 1, to, source, gmis::Relocation::global);
    above += pair[0].a >= 0.5 ? 1 : 0;
  }
  CHECK(test::normal_p_value((above - runs * 0.375) / std::sqrt(runs * 0.375 * 0.625)) > 1e-5);
}

// 4 problems × (mean, variance) of the estimate that does not adapt.
TEST_CASE("adaptive MIS: as N3 without adaptation, weights and proposals as defined with it", "[mis]") {
  const double level = test::sidak_level(1e-4, 8);
  gmis::Philox source(gmis_test::seed(94));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const bool is_unit = problem.breakpoints.front() >= 0.0;
    const four::Density first = is_unit ? four::uniform(0.0, 1.0) : four::logistic(1.0, 2.0);
    const auto keep = [&](auto, auto) { return first; };
    std::vector<double> fixed(4000);
    const auto fit = [&](std::span<const double> x, std::span<const double> w) {
      double sum = 0.0, mean = 0.0, square = 0.0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        sum += w[i];
        mean += w[i] * x[i];
        square += w[i] * x[i] * x[i];
      }
      if (!(sum > 0.0)) return first;
      mean /= sum;
      if (is_unit)
        return four::ramp(std::clamp(12.0 * (mean - 0.5), -1.5, 1.5));  // the mean of a ramp is 1/2 + slope/12
      const double variance = std::max(0.25, square / sum - mean * mean);
      return four::logistic(mean, 1.2 * std::sqrt(variance * 3.0) / test::pi);
    };
    for (std::size_t i = 0; i < fixed.size(); ++i) {
      fixed[i] = gmis::estimate_adaptive(problem.f, first, 10, 3, keep, source).mean;
      if (i >= 5) continue;
      const auto result = gmis::estimate_adaptive(problem.f, first, 50, 5, fit, source);
      double sizes = 0.0, squares = 0.0;
      for (const double weight : result.weights) {
        sizes += std::abs(weight);
        squares += weight * weight;
      }
      CHECK(result.effective_sample_size == Approx(sizes * sizes / squares).epsilon(1e-12));
      CHECK(result.density_evaluations == 50 * 25);
      double sum = 0.0;
      for (std::size_t s = 0; s < result.samples.size(); ++s) {
        double density = 0.0;  // the weights are those of the mixture of the five proposals
        for (std::size_t t = 0; t < 5; ++t) density += result.proposals[t].pdf(result.samples[s]);
        CHECK(result.weights[s] == Approx(problem.f(result.samples[s]) / density / 50.0).epsilon(1e-12));
        sum += result.weights[s];
      }
      CHECK(sum == Approx(result.mean).epsilon(1e-12));
      CHECK(result.proposals.size() == 6);
      for (std::size_t t = 1; t <= 5; ++t) {  // each is fitted to the samples before it under the mixture so far
        const std::span<const double> x(result.samples.data(), 50 * t);
        std::vector<double> w;
        for (const double place : x) {
          double density = 0.0;
          for (std::size_t past = 0; past < t; ++past) density += result.proposals[past].pdf(place);
          w.push_back(std::abs(problem.f(place) / density / 50.0));
        }
        const four::Density expected = fit(x, w);
        CHECK(result.proposals[t].a == Approx(expected.a).margin(1e-12));
        CHECK(result.proposals[t].b == Approx(expected.b).margin(1e-12));
      }
    }
    CHECK(test::mean_p_value(test::moments_of(fixed), problem.integral) > level);
    const std::vector<four::Density> alone{first};
    const gmis::TabulatedProblem table(problem.f, alone, problem.nodes());
    const auto interval = test::bootstrap_variance_interval(fixed, level, source);
    CHECK(interval.contains(exact_variance(gmis::Scheme::N1, table) / 30.0));
  }
}

namespace {

/// A proposal over three numbers, and a fit to weighted ones: a fifth of it stays uniform.
struct OfThree {
  std::array<double, 3> probability{0.5, 0.3, 0.2};
  std::size_t sample(gmis::UniformSource auto& source) const {
    const double u = gmis::uniform<double>(source);
    return u < probability[0] ? 0 : u < probability[0] + probability[1] ? 1 : 2;
  }
  double pdf(std::size_t i) const { return probability[i]; }
};
OfThree fitted(std::span<const std::size_t> x, std::span<const double> weights) {
  std::array<double, 3> in_cell{};
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    in_cell[x[i]] += weights[i];
    sum += weights[i];
  }
  OfThree result;
  for (std::size_t c = 0; c < 3; ++c)
    result.probability[c] = sum > 0.0 ? 0.2 / 3.0 + 0.8 * in_cell[c] / sum : 1.0 / 3.0;
  return result;
}

struct AdaptiveMoments {
  long double mean = 0.0L, second = 0.0L, stated_variance = 0.0L;
};
/// The moments by all outcomes of all iterations, each with the probability that its own proposals
/// give it.
AdaptiveMoments all_outcomes(const std::array<double, 3>& f, std::size_t each, std::size_t iterations) {
  AdaptiveMoments moments;
  std::vector<std::size_t> x;
  std::vector<OfThree> q(1);
  const auto weights = [&] {
    std::vector<double> result;
    for (const std::size_t i : x) {
      double density = 0.0;
      for (const OfThree& proposal : q) density += proposal.pdf(i);
      result.push_back(f[i] / density / static_cast<double>(each));
    }
    return result;
  };
  const auto go = [&](auto&& self, long double probability) -> void {
    if (x.size() == each * q.size()) {
      std::vector<double> w = weights();
      if (q.size() == iterations) {
        long double sum = 0.0L, squares = 0.0L;
        for (const double weight : w) sum += static_cast<long double>(weight);
        const long double n = static_cast<long double>(w.size());
        for (const double weight : w) {  // n weights of mean sum/n: the variance of their sum as if independent
          const long double difference = static_cast<long double>(weight) - sum / n;
          squares += difference * difference;
        }
        moments.mean += probability * sum;
        moments.second += probability * sum * sum;
        moments.stated_variance += probability * squares * n / (n - 1.0L);
        return;
      }
      for (double& weight : w) weight = std::abs(weight);
      q.push_back(fitted(x, w));
      self(self, probability);
      q.pop_back();
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      x.push_back(i);
      self(self, probability * static_cast<long double>(q.back().pdf(i)));
      x.pop_back();
    }
  };
  go(go, 1.0L);
  return moments;
}

}  // namespace

// 4 problems × (mean with its bias, variance, mean of the stated variance). The bias is known, so
// nothing is allowed for it.
TEST_CASE("adaptive MIS: mean, bias and stated error by all outcomes", "[mis]") {
  const double level = test::sidak_level(1e-4, 12);
  gmis::Philox source(gmis_test::seed(96));
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    std::array<double, 3> f;
    for (std::size_t i = 0; i < 3; ++i)
      f[i] = problem.f(problem.breakpoints.front() < 0.0 ? -2.5 + 2.2 * static_cast<double>(i)
                                                         : 0.15 + 0.33 * static_cast<double>(i));
    const auto exact = all_outcomes(f, 2, 3);
    std::vector<double> means(20000), stated(20000);
    for (std::size_t r = 0; r < means.size(); ++r) {
      const auto result = gmis::estimate_adaptive([&](std::size_t i) { return f[i]; }, OfThree{}, 2, 3, fitted, source);
      means[r] = result.mean;
      stated[r] = result.standard_error.value() * result.standard_error.value();
    }
    CHECK(test::mean_p_value(test::moments_of(means), static_cast<double>(exact.mean)) > level);
    CHECK(test::mean_p_value(test::moments_of(stated), static_cast<double>(exact.stated_variance)) > level);
    const auto interval = test::bootstrap_variance_interval(means, level, source);
    CAPTURE(interval.low, interval.high);
    CHECK(interval.contains(static_cast<double>(exact.second - exact.mean * exact.mean)));

    // The bias is of the order 1/n: times n, it stays in one range from 2 to 4 samples an
    // iteration. No chance in this.
    const long double truth =
        static_cast<long double>(f[0]) + static_cast<long double>(f[1]) + static_cast<long double>(f[2]);
    std::array<double, 3> scaled;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t each = std::size_t{1} << k;
      scaled[k] = static_cast<double>((all_outcomes(f, each, 2).mean - truth) * static_cast<long double>(each));
    }
    CHECK(std::abs(scaled[2]) < 2.0 * std::abs(scaled[1]));  // falls as the number of samples doubles
    CHECK(std::abs(scaled[2]) > 0.5 * std::abs(scaled[1]));
  }
}

TEST_CASE("adaptive proposals: each evaluation of a density is counted once", "[mis]") {
  struct Counting {  // uniform, but for a third of the samples, whose density is 0
    std::uint64_t* calls;
    double sample(gmis::Philox& source) const { return gmis::uniform<double>(source); }
    double pdf(double x) const {
      ++*calls;
      return x < 1.0 / 3.0 ? 0.0 : 1.0;
    }
  };
  gmis::Philox source(gmis_test::seed(97));
  std::uint64_t calls = 0;
  const auto keep = [&](auto, auto) { return Counting{&calls}; };
  const auto f = [](double x) { return x > 2.0 / 3.0 ? std::nan("") : 1.0; };
  const auto result = gmis::estimate_adaptive(f, Counting{&calls}, 20, 4, keep, source);
  CHECK(result.rejected.zero_density > 0);
  CHECK(result.density_evaluations == calls);
  // What is rejected counts as zero: the mean is the share of the others.
  CHECK(result.rejected.non_finite_integrand > 0);
  CHECK(result.samples.size() == 80 - result.rejected.zero_density);
  CHECK(result.mean == Approx((80.0 - static_cast<double>(result.rejected.total())) / 80.0).epsilon(1e-12));
}

TEST_CASE("adaptive MIS: what cannot be used counts as zero, once, and by cause", "[mis]") {
  gmis::Philox source(gmis_test::seed(98));
  const double infinity = std::numeric_limits<double>::infinity();
  const auto check = [](const auto& result, std::uint64_t samples, double value) {
    double sum = 0.0;
    for (const double weight : result.weights) sum += weight;
    CHECK(result.rejected.total() > 0);
    CHECK(result.mean == Approx(sum).epsilon(1e-12));
    const double share = static_cast<double>(samples - result.rejected.total()) / static_cast<double>(samples);
    CHECK(result.mean == Approx(value * share).epsilon(1e-12));
    CHECK(std::isfinite(result.standard_error.value()));
    CHECK(std::isfinite(result.effective_sample_size));
  };
  const auto one = [](double) { return 1.0; };
  for (const double fault : {std::nan(""), infinity, -0.5}) {
    CAPTURE(fault);
    // The fault is in the later proposals, for old samples; then in the first, for new ones.
    const auto later = [&](auto x, auto weights) {
      for (const double weight : weights) CHECK(std::isfinite(weight));
      for (std::size_t i = 0; i < x.size(); ++i)
        if (x.size() > 40 && x[i] > 0.5) CHECK(weights[i] == 0.0);
      return test::FaultyDensity{x.size() < 40 ? 1.0 : fault};
    };
    const auto old_samples = gmis::estimate_adaptive(one, test::FaultyDensity{1.0}, 20, 4, later, source);
    CHECK(old_samples.rejected.total() == old_samples.rejected.non_finite_density);
    check(old_samples, 80, 1.0);
    const auto sound = [](auto, auto) { return test::FaultyDensity{1.0}; };
    const auto new_samples = gmis::estimate_adaptive(one, test::FaultyDensity{fault}, 20, 4, sound, source);
    CHECK(new_samples.rejected.total() == new_samples.rejected.non_finite_density);
    check(new_samples, 80, 1.0);
    // A value that is not finite where a density is at fault is counted once.
    const auto broken = [](double x) { return x > 0.25 ? std::nan("") : 1.0; };
    const auto both = gmis::estimate_adaptive(broken, test::FaultyDensity{fault}, 20, 4, sound, source);
    CHECK(both.rejected.non_finite_density > 0);
    CHECK(both.rejected.non_finite_integrand > 0);
    check(both, 80, 1.0);
  }
  // A quotient outside the range of double.
  const auto tiny = [](auto, auto) { return test::FaultyDensity{1e-10}; };
  const auto overflow = gmis::estimate_adaptive([](double x) { return x > 0.5 ? 1e300 : 1.0; },
                                                test::FaultyDensity{1e-10}, 20, 4, tiny, source);
  CHECK(overflow.rejected.total() == overflow.rejected.non_finite_contribution);
  check(overflow, 80, 1.0);
  // In range once a second proposal is in the mixture: not rejected.
  const auto wide = [](auto, auto) { return test::FaultyDensity{1.0}; };
  const auto mended = gmis::estimate_adaptive([](double x) { return x > 0.5 ? 1e100 : 1.0; },
                                              test::FaultyDensity{1e-250}, 40, 2, wide, source);
  CHECK(mended.rejected.total() == 0);
  CHECK(mended.mean > 1e97);
}

TEST_CASE("adaptive MIS: a single sample states no error", "[mis]") {
  gmis::Philox source(gmis_test::seed(99));
  const auto keep = [](auto, auto) { return test::FaultyDensity{1.0}; };
  const auto one = [](double) { return 1.0; };
  CHECK_FALSE(gmis::estimate_adaptive(one, test::FaultyDensity{1.0}, 1, 1, keep, source).standard_error.has_value());
  CHECK(gmis::estimate_adaptive(one, test::FaultyDensity{1.0}, 2, 1, keep, source).standard_error.has_value());
}

// 50 rounds × 200 runs: rounding gives the variance of a constant a random sign.
TEST_CASE("self-normalised: the standard error of a constant is a number", "[mis]") {
  const std::vector<test::Normal> normals{{-1.0, 2.0}, {1.0, 2.0}};
  const auto target = [](double x) { return std::exp(-0.5 * x * x); };
  const auto constant = [](double) { return std::array{3.3}; };
  for (std::uint64_t run = 0; run < 200; ++run) {
    gmis::Philox source(gmis_test::seed(1000 + run));
    const auto estimate = gmis::estimate_self_normalised(target, constant, normals, Counts{3, 3}, 50, source);
    const double error = estimate.standard_error(0).value();
    CHECK((error >= 0.0 && error < 1e-6));
    CHECK((*estimate.covariance)[0][0] >= 0.0);
  }
}

TEST_CASE("chosen groups: the best of all partitions, by brute force", "[mis]") {
  gmis::Philox source(gmis_test::seed(95));
  // Six proposals in an order that suits neither strided nor consecutive groups; four integrands.
  const std::vector<four::Density> unit{four::uniform(0.0, 1.0), four::ramp(1.5),  four::ramp(1.2),
                                        four::ramp(-1.5),        four::ramp(-1.2), four::ramp(0.5)};
  const std::vector<four::Density> line{four::logistic(-3.0, 1.2), four::logistic(-2.5, 1.1), four::logistic(3.0, 1.3),
                                        four::logistic(0.2, 1.2),  four::logistic(0.0, 1.5),  four::logistic(2.5, 1.1)};
  for (const four::Problem& problem : problems) {
    CAPTURE(problem.name);
    const auto& proposals = problem.breakpoints.front() < 0.0 ? line : unit;
    const gmis::TabulatedProblem table(problem.f, proposals, problem.nodes());
    for (const std::size_t size : {std::size_t{2}, std::size_t{3}}) {
      const auto chosen = gmis::best_groups(table, size);
      const double variance = exact_moments(chosen, table).variance;
      double least = 1e300, largest = 0.0;
      Counts group_of(6);
      const auto search = [&](auto&& self, std::size_t k) -> void {
        if (k == 6) {
          const gmis::Groups<> groups{std::span<const std::uint32_t>(group_of)};
          const double other = exact_moments(groups, table).variance;
          least = std::min(least, other);
          largest = std::max(largest, other);
          return;
        }
        for (std::uint32_t g = 0; g < 6 / size; ++g) {
          if (static_cast<std::size_t>(
                  std::count(group_of.begin(), group_of.begin() + static_cast<std::ptrdiff_t>(k), g)) >= size)
            continue;
          group_of[k] = g;
          self(self, k + 1);
        }
      };
      search(search, 0);
      CHECK(variance <= 1.02 * least);
      CHECK(variance < largest);
      CHECK(chosen.density_evaluations_per_round() == 6 * size);
    }
    const gmis::PilotSamples pilot(problem.f, proposals, 500, source);
    const auto by_pilot = gmis::best_groups(pilot.problem(), 2);
    CHECK(exact_moments(by_pilot, table).variance <= 1.3 * exact_moments(gmis::best_groups(table, 2), table).variance);
    const auto run = gmis::estimate_partial(problem.f, proposals, by_pilot, 4000, source);
    CHECK(test::normal_p_value((run.mean - problem.integral) / run.standard_error.value()) > 1e-5);
  }
  CHECK_THROWS_AS(gmis::best_groups(test::tabulated(problems[0]), 0), std::invalid_argument);
  const std::vector<four::Density> halves{four::uniform(0.0, 0.5), four::uniform(0.0, 0.5), four::uniform(0.5, 1.0),
                                          four::uniform(0.5, 1.0)};
  const gmis::TabulatedProblem split(four::waves, halves, problems[3].nodes());
  CHECK(has_full_support(gmis::best_groups(split, 2), split));
  CHECK_THROWS_AS(gmis::best_groups(split, 1), std::invalid_argument);
}
