#pragma once

#include <cstddef>
#include <cstdint>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/methods/stochastic_mis.hpp"

namespace gmis {

/// An unbiased estimate of 1/q(x), q(x) = ∫ q(x | t) p(t) dt being the marginal density of a
/// family, by the number of trials to the first success [Booth 2007]: a technique t is drawn and
/// accepted with probability q(x | t)/B; the trials K are geometric, and E[K/B] = 1/q(x). (1/q̂ of
/// an unbiased q̂ is biased: E[1/q̂] > 1/q.)
struct InverseDensity {
  double value;          ///< K/B; 0 when `max_trials` were not enough
  std::uint64_t trials;  ///< K: also the densities evaluated
};

/// `bound`: B ≥ q(x | t) for all t; a density above it throws std::invalid_argument, since the
/// estimate would be wrong. The mean of K is B/q(x). `max_trials` ends the search; a probability of
/// (1 − q/B)^max_trials of the estimate is then lost.
template <class Family, class X, UniformSource Source>
requires TechniqueFamily<Family, Source>
[[nodiscard]] InverseDensity inverse_marginal_density(const Family& family, const X& x, double bound, Source& source,
                                                      std::uint64_t max_trials = 1'000'000'000) {
  for (std::uint64_t trial = 1; trial <= max_trials; ++trial) {
    const double density = static_cast<double>(family.pdf(family.draw(source), x));
    if (!(density >= 0.0 && density <= bound)) [[unlikely]]
      reject_argument("a density exceeds the bound: give the largest value that pdf can return");
    if (uniform<double>(source) * bound < density) return {static_cast<double>(trial) / bound, trial};
  }
  return {0.0, max_trials};
}

/// Estimates ∫ f with samples of the family, each weighted by an unbiased estimate of 1/q(x); the
/// marginal is not needed. Variance of one sample: ∫ f² (2 − q/B)/q − I², so at most twice the
/// second moment of continuous MIS, for B/q densities a sample. Unbiased when q > 0 wherever f ≠ 0
/// (but for `max_trials`).
template <class Integrand, class Family, UniformSource Source>
requires TechniqueFamily<Family, Source>
[[nodiscard]] auto estimate_marginal(Integrand&& f, const Family& family, double bound, std::size_t samples,
                                     std::uint64_t rounds, Source& source) {
  using X = FamilyValue<Family, Source>;
  using F = SummandOf<Integrand, X>;
  using A = typename EstimateAccumulator<F>::A;
  if (samples == 0) reject_argument("give a round at least one sample");
  require_rounds(rounds);
  if (!(bound > 0.0 && std::isfinite(bound))) reject_argument("the bound must be a positive number");
  EstimateAccumulator<F> moments;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    typename EstimateAccumulator<F>::Channels sum{};
    RoundCounts cost;
    for (std::size_t i = 0; i < samples; ++i) {
      const X x = family.sample(family.draw(source), source);
      const InverseDensity inverse = inverse_marginal_density(family, x, bound, source);
      cost.density_evaluations += inverse.trials;
      if (inverse.value == 0.0) [[unlikely]] {
        ++cost.zero_density;
        continue;
      }
      const auto value = moments.quotient(value_of(f, x), 1.0 / inverse.value);
      for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += value[c] / static_cast<A>(samples);
    }
    moments.add_estimate(sum, samples, cost);
  }
  return moments.result();
}

}  // namespace gmis
