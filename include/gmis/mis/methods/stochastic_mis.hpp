#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/estimate.hpp"

/// \file
/// Multiple importance sampling over a continuum of techniques [West, Georgiev, Gruson, Hachisuka:
/// Continuous multiple importance sampling, 2020]: a technique t is drawn, then a sample from it.

namespace gmis {

/// A family of techniques:
/// - `draw(source)`: a technique t (any type), from a distribution whose density nobody needs to
///   know;
/// - `sample(t, source)`: a sample x of technique t;
/// - `pdf(t, x)`: the density q(x | t).
template <class Family, class Source = Philox>
concept TechniqueFamily = requires(const Family& family, Source& source) {
  family.sample(family.draw(source), source);
  { family.pdf(family.draw(source), family.sample(family.draw(source), source)) } -> std::floating_point;
};

/// A family that knows its marginal density q(x) = ∫ q(x | t) p(t) dt: `marginal_pdf(x)`.
template <class Family, class Source = Philox>
concept KnownMarginal = TechniqueFamily<Family, Source> && requires(const Family& family, Source& source) {
  { family.marginal_pdf(family.sample(family.draw(source), source)) } -> std::floating_point;
};

/// The technique that `draw` of a family returns.
template <class Family, class Source = Philox>
using TechniqueOf = std::remove_cvref_t<decltype(std::declval<const Family&>().draw(std::declval<Source&>()))>;
/// The sample that `sample` of a family returns.
template <class Family, class Source = Philox>
using FamilyValue = std::remove_cvref_t<decltype(std::declval<const Family&>().sample(
    std::declval<const TechniqueOf<Family, Source>&>(), std::declval<Source&>()))>;

/// Stochastic MIS: a round draws `techniques` ≥ 1 independent techniques, one sample of each, and
/// weights the samples by the balance heuristic among those drawn: Σ_i f(x_i)/Σ_j q(x_i | t_j). n²
/// densities a round; nothing of the marginal is needed. For a finite family with equal
/// probabilities and n = N it is scheme R2. Unbiased when q(x | t) > 0 for almost every t that can
/// be drawn, wherever f ≠ 0.
template <class Integrand, class Family, UniformSource Source>
requires TechniqueFamily<Family, Source>
[[nodiscard]] auto estimate_stochastic(Integrand&& f, const Family& family, std::size_t techniques,
                                       std::uint64_t rounds, Source& source) {
  using X = FamilyValue<Family, Source>;
  using F = SummandOf<Integrand, X>;
  if (techniques == 0) reject_argument("give a round at least one technique");
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  std::vector<TechniqueOf<Family, Source>> drawn;
  drawn.reserve(techniques);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    drawn.clear();
    for (std::size_t i = 0; i < techniques; ++i) drawn.push_back(family.draw(source));
    typename EstimateAccumulator<F>::Channels sum{};
    RoundCounts cost;
    for (const auto& own : drawn) {
      const X x = family.sample(own, source);
      double density = 0.0;
      for (const auto& technique : drawn) density += static_cast<double>(family.pdf(technique, x));
      cost.density_evaluations += techniques;
      if (!is_usable(density)) [[unlikely]] {
        ++(density == 0.0 ? cost.zero_density : cost.non_finite_density);
        continue;
      }
      const auto value = moments.quotient(value_of(f, x), density);
      for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += value[c];
    }
    moments.add_estimate(sum, techniques, cost);
  }
  return moments.result();
}

/// Continuous MIS: f/q with the marginal q, which is the balance heuristic over all techniques: the
/// optimal weights when every sample draws its own technique. `samples` ≥ 1 a round, one density
/// each. Variance (∫ f²/q − I²)/n. Unbiased when q > 0 wherever f ≠ 0.
template <class Integrand, class Family, UniformSource Source>
requires KnownMarginal<Family, Source>
[[nodiscard]] auto estimate_continuous(Integrand&& f, const Family& family, std::size_t samples, std::uint64_t rounds,
                                       Source& source) {
  using X = FamilyValue<Family, Source>;
  using F = SummandOf<Integrand, X>;
  using A = typename EstimateAccumulator<F>::A;
  if (samples == 0) reject_argument("give a round at least one sample");
  require_rounds(rounds);
  EstimateAccumulator<F> moments;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    typename EstimateAccumulator<F>::Channels sum{};
    RoundCounts cost;
    for (std::size_t i = 0; i < samples; ++i) {
      const X x = family.sample(family.draw(source), source);
      const double density = static_cast<double>(family.marginal_pdf(x));
      ++cost.density_evaluations;
      if (!is_usable(density)) [[unlikely]] {
        ++(density == 0.0 ? cost.zero_density : cost.non_finite_density);
        continue;
      }
      const auto value = moments.quotient(value_of(f, x), density);
      for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += value[c] / static_cast<A>(samples);
    }
    moments.add_estimate(sum, samples, cost);
  }
  return moments.result();
}

}  // namespace gmis
