#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
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
  double standard_error =
      0.0;  ///< as if the samples were independent draws of the final mixture: close, a little optimistic
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
  result.proposals.push_back(first);
  for (std::size_t t = 0; t < iterations; ++t) {
    const P current = result.proposals.back();
    for (std::size_t i = 0; i < densities.size(); ++i)
      densities[i] += static_cast<double>(current.pdf(result.samples[i]));
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
      for (std::size_t k = 0; k < t; ++k) sum += static_cast<double>(result.proposals[k].pdf(x));
      sum += own;
      result.density_evaluations += t;
      double value = static_cast<double>(f(x));
      if (!std::isfinite(value)) {
        ++result.rejected.non_finite_integrand;
        value = 0.0;
      }
      result.samples.push_back(x);
      values.push_back(value);
      densities.push_back(sum);
    }
    result.weights.resize(values.size());
    std::vector<double> sizes(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      result.weights[i] = values[i] / densities[i] / static_cast<double>(samples_each);
      sizes[i] = std::abs(result.weights[i]);
    }
    result.proposals.push_back(fit(std::span<const X>(result.samples), std::span<const double>(sizes)));
  }
  double sizes = 0.0, squares = 0.0;
  for (const double weight : result.weights) {
    result.mean += weight;
    sizes += std::abs(weight);
    squares += weight * weight;
  }
  const double n = static_cast<double>(samples_each * iterations);
  result.effective_sample_size = squares > 0.0 ? sizes * sizes / squares : 0.0;
  result.standard_error =
      n > 1.0 ? std::sqrt(std::max(0.0, squares - result.mean * result.mean / n) * n / (n - 1.0)) : 0.0;
  return result;
}

}  // namespace gmis
