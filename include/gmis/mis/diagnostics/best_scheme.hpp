#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "gmis/mis/diagnostics/averaged_variance.hpp"
#include "gmis/mis/diagnostics/exact_variance.hpp"
#include "gmis/mis/partial_mixture.hpp"

namespace gmis {

/// Costs of the parts of a round, in nanoseconds or any other unit, as measured by the caller.
struct CostModel {
  double per_density;  ///< one evaluation of one proposal's density at one point
  double per_sample;   ///< all else about a sample: drawing it, evaluating f, dividing
};

/// Samples of a problem with all densities at each: what `best_scheme` works out variances from.
/// Everything is kept relative to the mixture ψ at the sample, so that densities outside the range
/// of double do no harm.
class PilotSamples {
 public:
  /// Draws `rounds` ≥ 1 rounds, one sample of each proposal a round. The integrand returns a number
  /// or a `LogValue`; give it the channel, or the mean of the channels, whose variance counts.
  /// Throws std::invalid_argument when no sample was usable, and for arguments that `estimate`
  /// rejects.
  template <class Integrand, class P, class Source>
  PilotSamples(Integrand&& f, const P& proposals, std::uint64_t rounds, Source&& source)
      : problem_(tabulate(f, proposals, rounds, source, rejected_)) {}

  /// The samples as the nodes of a quadrature rule: a sum over them estimates an integral.
  [[nodiscard]] const TabulatedProblem& problem() const& noexcept { return problem_; }
  /// The problem, moved out.
  [[nodiscard]] TabulatedProblem problem() && { return std::move(problem_); }
  const TabulatedProblem& problem() const&& = delete;  // it would end with the pilot
  /// Samples that are not in the problem, or with a value of 0, because f, a density or their ratio
  /// was not a usable number.
  [[nodiscard]] std::uint64_t rejected() const noexcept { return rejected_; }

 private:
  template <class Integrand, class P, class Source>
  [[nodiscard]] static TabulatedProblem tabulate(Integrand& f, const P& proposals, std::uint64_t rounds, Source& source,
                                                 std::uint64_t& rejected) {
    if constexpr (detail::explain_arguments<Integrand, P, Source>())
      return tabulate_set(f, as_proposal_set<Source>(proposals), rounds, source, rejected);
    else
      return {{}, {}, {}};
  }

  template <class Integrand, class Set, class Source>
  [[nodiscard]] static TabulatedProblem tabulate_set(Integrand& f, const Set& set, std::uint64_t rounds, Source& source,
                                                     std::uint64_t& rejected) {
    using F = SummandOf<Integrand, typename Set::Value>;
    static_assert(SpectrumTraits<F>::channel_count == 1, "a pilot needs an integrand with one channel");
    require_rounds(rounds);
    rejected = 0;
    const std::size_t n = set.size();
    Workspace<typename Set::Density, dynamic_capacity> workspace;
    std::vector<double> values, by_sample, made(n);
    const auto visit = [&](const auto& x, auto psi, std::size_t index) {
      made[index] += 1.0;
      const F value = value_of(f, x);
      double relative = std::numeric_limits<double>::quiet_NaN();
      if (is_finite(value)) relative = ratio<double>(SpectrumTraits<F>::channel(value, 0), psi);
      if (!std::isfinite(relative)) ++rejected;
      values.push_back(std::isfinite(relative) ? relative : 0.0);
      DensitiesAt<Set> densities(set, x, workspace.densities.data());
      densities.expect_all();
      for (std::size_t i = 0; i < n; ++i) {
        if constexpr (is_log_set<Set>)
          by_sample.push_back(std::exp(static_cast<double>(densities[i]) - static_cast<double>(psi.log)));
        else
          by_sample.push_back(static_cast<double>(densities[i]) / static_cast<double>(psi));
      }
    };
    for (std::uint64_t round = 0; round < rounds; ++round) {
      const RoundCounts counts = sample_round<Scheme::N3>(set, EqualAllocation{}, source, workspace, visit);
      rejected += counts.zero_density + counts.non_finite_density;
    }
    require_argument(!values.empty(), "no sample of the pilot was usable");

    const std::size_t count = values.size();
    const std::vector<double> weights(count, 1.0 / (static_cast<double>(rounds) * static_cast<double>(n)));
    // Every density is scaled to integrate, over these nodes, to what it is known to: one, or its
    // share of samples that were made. With that no variance comes out negative, however short the
    // pilot (Cauchy and Schwarz).
    std::vector<double> by_proposal(n * count);
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0.0;
      for (std::size_t sample = 0; sample < count; ++sample) sum += by_sample[sample * n + i] * weights[sample];
      const double share = made[i] / static_cast<double>(rounds);
      if (sum > 0.0)  // divided first: 1 / sum may be infinite
        for (std::size_t sample = 0; sample < count; ++sample)
          by_proposal[i * count + sample] = by_sample[sample * n + i] / sum * share;
    }
    return {std::move(values), weights, std::move(by_proposal)};
  }

  std::uint64_t rejected_ = 0;
  TabulatedProblem problem_;
};

/// One way of combining the proposals, with what the pilot says of it.
struct SchemeCandidate {
  Scheme scheme;           ///< which it is
  std::size_t group_size;  ///< 0, or P: the partial deterministic mixture in groups of P (strided), `scheme` being N3
  bool is_unbiased;        ///< false when the pilot met a place that a proposal (a group) does not cover
  double
      variance;  ///< of one round; NaN when it is biased, +infinity beyond the range of double, 0 below 1e-12 (∫ |f|)²
  double density_evaluations;  ///< in one round, their mean
  double cost;                 ///< of one round, in the unit of the cost model

  /// False for a variance beyond the range of double: then it is no better than any other.
  [[nodiscard]] bool has_finite_variance() const noexcept { return std::isfinite(variance); }
  /// Objective: variance × cost, the cost of reaching a given variance.
  [[nodiscard]] double variance_times_cost() const noexcept { return variance * cost; }
};

/// The choice and the figures behind it.
struct SchemeChoice {
  std::vector<SchemeCandidate> candidates;  ///< the six schemes in the order of `all_schemes`, then P ascending
  std::size_t best;                         ///< the index of the unbiased one with the least variance × cost

  /// The best one.
  [[nodiscard]] const SchemeCandidate& chosen() const& noexcept { return candidates[best]; }
  /// The best one.
  [[nodiscard]] SchemeCandidate chosen() const&& { return candidates[best]; }
};

/// The sizes of groups that `best_scheme` tries: 2, 3, 4, 6, 8, 12, 16, … below N, each as large as
/// the groups really become (with N = 4, groups of 3 are groups of 2) and once.
[[nodiscard]] inline std::vector<std::size_t> group_sizes_to_try(std::size_t proposal_count) {
  std::vector<std::size_t> sizes;
  const auto try_size = [&](std::size_t size) {
    if (size >= proposal_count) return;
    const std::size_t groups = (proposal_count + size - 1) / size;
    const std::size_t largest = (proposal_count + groups - 1) / groups;
    if (sizes.empty() || sizes.back() != largest) sizes.push_back(largest);
  };
  for (std::size_t size = 2; size < proposal_count; size *= 2) {
    try_size(size);
    try_size(size + size / 2);
  }
  return sizes;
}

/// Every scheme, and the partial mixture for `group_sizes_to_try`, judged by variance × cost on the
/// exact formulas, `problem` being a table of nodes: of a quadrature rule for the exact answer, of
/// a pilot for an estimate of it. `averaged_draws` random draws of the indices stand in for the
/// sums over all of them for R2 and N2 where N > 6. One whose variance is not finite is never
/// better than one whose variance is.
///
/// Throws std::invalid_argument for negative costs, fewer than two draws, and when no unbiased
/// scheme has a finite variance.
template <UniformSource Source>
[[nodiscard]] SchemeChoice best_scheme(const TabulatedProblem& problem, const CostModel& costs, Source& source,
                                       std::uint64_t averaged_draws = 32) {
  constexpr std::size_t largest_exact = 6;
  require_argument(costs.per_density >= 0.0 && costs.per_sample >= 0.0 && std::isfinite(costs.per_density) &&
                       std::isfinite(costs.per_sample),
                   "costs must be non-negative numbers");
  require_argument(averaged_draws >= 2, "best_scheme needs at least two draws of the indices");
  const std::size_t n = problem.proposal_count();
  const double count = static_cast<double>(n);
  const bool all_cover = problem.has_full_support();
  SchemeChoice choice{{}, 0};
  double absolute = 0.0;
  for (std::size_t i = 0; i < problem.node_count(); ++i)
    absolute += std::abs(problem.weights()[i] * problem.values()[i]);
  const double rounding = 1e-12 * absolute * absolute;
  const auto add = [&](Scheme scheme, std::size_t group_size, bool is_unbiased, double variance, double evaluations) {
    // Rounding errors around a variance of 0 must not decide; NaN stays.
    choice.candidates.push_back({scheme, group_size, is_unbiased, variance <= rounding ? 0.0 : variance, evaluations,
                                 evaluations * costs.per_density + count * costs.per_sample});
  };

  for (const Scheme scheme : all_schemes) {
    const double distinct = count * (1.0 - std::pow(1.0 - 1.0 / count, count));
    const double evaluations =
        scheme == Scheme::R2 ? count * distinct : static_cast<double>(density_evaluations_per_round(scheme, n));
    if (needs_full_support(scheme) && !all_cover) {
      add(scheme, 0, false, std::numeric_limits<double>::quiet_NaN(), evaluations);
    } else if ((scheme == Scheme::R2 || scheme == Scheme::N2) && n > largest_exact) {
      add(scheme, 0, true, averaged_variance(scheme, problem, averaged_draws, source).value, evaluations);
    } else {
      add(scheme, 0, true, exact_variance(scheme, problem), evaluations);
    }
  }
  for (const std::size_t size : group_sizes_to_try(n)) {
    const Groups<> groups(n, size);
    add(Scheme::N3, size, has_full_support(groups, problem), exact_moments(groups, problem).variance,
        static_cast<double>(groups.density_evaluations_per_round()));
  }

  // Ties within rounding go to the cheaper candidate, then to the first: those without random
  // indices come first.
  const auto is_better = [](const SchemeCandidate& a, const SchemeCandidate& b) {
    const bool a_can_serve = a.is_unbiased && a.has_finite_variance(),
               b_can_serve = b.is_unbiased && b.has_finite_variance();
    if (!a_can_serve || !b_can_serve) return a_can_serve && !b_can_serve;
    const double score = a.variance_times_cost(), other = b.variance_times_cost();
    if (std::abs(score - other) > 1e-9 * other) return score < other;
    return a.cost < b.cost;
  };
  constexpr std::size_t random_schemes = 3;
  choice.best = random_schemes;
  for (std::size_t i = 1; i < choice.candidates.size(); ++i) {
    const std::size_t candidate = (random_schemes + i) % choice.candidates.size();
    if (is_better(choice.candidates[candidate], choice.candidates[choice.best])) choice.best = candidate;
  }
  require_argument(
      choice.chosen().is_unbiased && choice.chosen().has_finite_variance(),
      "no scheme is unbiased with a finite variance here: the proposals do not cover the integrand, or its "
      "variance leaves the range of double");
  return choice;
}

}  // namespace gmis
