#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "gmis/core/argument_error.hpp"
#include "gmis/mis/contribution.hpp"
#include "gmis/mis/estimate.hpp"
#include "gmis/mis/mixture.hpp"
#include "gmis/mis/proposal_set.hpp"

namespace gmis {

/// The result of adaptive MIS: the estimate, every sample with its final weight, and every proposal
/// that was used.
template <class P, class X = ValueOf<P>>
struct AdaptiveEstimate {
  double mean = 0.0;  ///< of ∫ f
  /// Computed as if the samples were independent draws of the final mixture: close, a little
  /// optimistic. Nothing for a single sample.
  std::optional<double> standard_error{};
  double effective_sample_size = 0.0;     ///< (Σ |w|)²/Σ w²
  std::vector<X> samples{};               ///< those that were made
  std::vector<double> weights{};          ///< f/(n ψ), ψ the mixture of all iterations: their sum is `mean`
  std::vector<P> proposals{};             ///< of each iteration, and the one fitted last
  std::uint64_t density_evaluations = 0;  ///< evaluations of a proposal's density
  Rejected rejected{};                    ///< samples that count as zero, by cause
};

/// Adaptive multiple importance sampling [Cornuet, Marin, Mira, Robert 2012]: iteration t draws
/// `samples_each` samples of a proposal fitted to all samples before it, and *all* samples, old
/// ones too, are weighted anew by the mixture of the proposals so far. `fit(samples, weights)`
/// returns the next proposal from spans of the samples and of |weights|; weights are not normalised
/// and may all be zero. For T iterations T² n densities.
///
/// A sample with a density that is infinite, NaN or negative under any of the T proposals, or a
/// value or quotient that is not finite, gets the weight zero and is counted once.
///
/// Not unbiased: old samples are divided by proposals that were fitted to them. The bias is of the
/// order 1/n and the standard deviation of a run of the order 1/√n; with a `fit` that ignores its
/// arguments there is no bias. Keep the fitted tails wider than those of f. f returns one number.
template <class Integrand, class P, class Fit, UniformSource Source>
requires AnyProposal<P, Source> && HasPdf<P, ValueOf<P, Source>>
[[nodiscard]] AdaptiveEstimate<P, ValueOf<P, Source>> estimate_adaptive(Integrand&& f, const P& first,
                                                                        std::size_t samples_each,
                                                                        std::size_t iterations, Fit&& fit,
                                                                        Source& source) {
  if (samples_each == 0 || iterations == 0) reject_argument("give at least one sample and one iteration");
  using X = ValueOf<P, Source>;
  AdaptiveEstimate<P, X> result;
  std::vector<double> values, densities;  // f, and Σ_t q_t, at every sample
  // NaN in place of a negative density, so that the sum tells.
  const auto density_of = [](const P& proposal, const X& x) {
    const double density = static_cast<double>(proposal.pdf(x));
    return density >= 0.0 ? density : std::numeric_limits<double>::quiet_NaN();
  };
  const auto quotient = [&](std::size_t i) { return values[i] / densities[i] / static_cast<double>(samples_each); };
  result.proposals.push_back(first);
  for (std::size_t t = 0; t < iterations; ++t) {
    const P current = result.proposals.back();
    for (std::size_t i = 0; i < densities.size(); ++i) densities[i] += density_of(current, result.samples[i]);
    result.density_evaluations += densities.size();
    for (std::size_t i = 0; i < samples_each; ++i) {
      const auto x = current.sample(source);
      static_assert(!SampleResult<std::remove_cvref_t<decltype(x)>>::can_fail, "the proposals must not fail");
      const double own = static_cast<double>(current.pdf(x));
      ++result.density_evaluations;
      if (!is_usable(own)) {
        ++(own == 0.0 ? result.rejected.zero_density : result.rejected.non_finite_density);
        continue;
      }
      double sum = 0.0;
      for (std::size_t k = 0; k < t; ++k) sum += density_of(result.proposals[k], x);
      sum += own;
      result.density_evaluations += t;
      result.samples.push_back(x);
      values.push_back(static_cast<double>(f(x)));
      densities.push_back(sum);
    }
    result.weights.resize(values.size());
    std::vector<double> sizes(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double weight = quotient(i);
      result.weights[i] = std::isfinite(weight) ? weight : 0.0;
      sizes[i] = std::abs(result.weights[i]);
    }
    result.proposals.push_back(fit(std::span<const X>(result.samples), std::span<const double>(sizes)));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_usable(densities[i]))
      ++result.rejected.non_finite_density;
    else if (!std::isfinite(values[i]))
      ++result.rejected.non_finite_integrand;
    else if (!std::isfinite(quotient(i)))
      ++result.rejected.non_finite_contribution;
  }
  double sizes = 0.0, squares = 0.0;
  for (const double weight : result.weights) {
    result.mean += weight;
    sizes += std::abs(weight);
    squares += weight * weight;
  }
  const double n = static_cast<double>(samples_each * iterations);
  result.effective_sample_size = squares > 0.0 ? sizes * sizes / squares : 0.0;
  if (n > 1.0)
    result.standard_error = std::sqrt(std::max(0.0, squares - result.mean * result.mean / n) * n / (n - 1.0));
  return result;
}

}  // namespace gmis
