#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/arguments.hpp"
#include "gmis/mis/bounded_set.hpp"
#include "gmis/mis/contribution.hpp"
#include "gmis/mis/integrand.hpp"
#include "gmis/mis/moments.hpp"
#include "gmis/mis/round.hpp"

namespace gmis {

/// Samples that contributed zero because something was wrong with them, by cause.
struct Rejected {
  std::uint64_t non_finite_integrand = 0;     ///< f was NaN or infinite (in any channel)
  std::uint64_t zero_density = 0;             ///< a proposal gave its own sample a density of zero
  std::uint64_t non_finite_density = 0;       ///< a density was infinite, NaN or negative
  std::uint64_t non_finite_contribution = 0;  ///< f and φ were fine, f / φ left the range of the accumulator

  /// Over all causes.
  [[nodiscard]] constexpr std::uint64_t total() const noexcept {
    return non_finite_integrand + zero_density + non_finite_density + non_finite_contribution;
  }
  friend constexpr bool operator==(const Rejected&, const Rejected&) = default;
};

/// The result of `estimate`. V is double (long double for long double integrands), or a vector of
/// it for a spectrum.
template <class V>
struct Estimate {
  V mean{};                                 ///< the estimate of ∫ f
  std::optional<V> variance{};              ///< of *one round*, estimated between rounds; nothing for a single round
  std::optional<V> standard_error{};        ///< of `mean`; nothing for a single round
  std::uint64_t rounds = 0;                 ///< R
  std::uint64_t samples = 0;                ///< R N, or R Σ n_i; failed and rejected ones included
  std::uint64_t density_evaluations = 0;    ///< of proposals
  std::uint64_t integrand_evaluations = 0;  ///< of f
  std::uint64_t failed_samples = 0;         ///< `sample` returned nothing; no error
  Rejected rejected{};                      ///< samples that count as zero because something is wrong, by cause
};

/// Sums the rounds of one estimate: the state between `estimate`'s rounds, for your own loop. The
/// accumulators of several threads can be merged.
template <Summable F>
class EstimateAccumulator {
  using Traits = SpectrumTraits<F>;

 public:
  /// The type that sums are kept in.
  using A = AccumulatorOf<typename Traits::Scalar>;
  /// Channels of f.
  static constexpr std::size_t channel_count = static_cast<std::size_t>(Traits::channel_count);
  /// One number for each channel.
  using Channels = std::array<A, channel_count>;
  using Mean = typename Rebound<std::conditional_t<channel_count == 1, A, F>, A>::Type;

  /// Runs one round with `run_round(visit)`, which is to call `visit(x, denominator, index)` and to
  /// return RoundCounts. Throws std::invalid_argument for a round of no samples.
  template <class Integrand, class RunRound>
  void add_round(Integrand& f, std::size_t sample_count, RunRound&& run_round) {
    require_argument(sample_count > 0, "a round of no samples: its mean is not a number");
    add_rounds(f, sample_count, 1, [&](RoundCounts& counts, auto&& visit) { counts = run_round(visit); });
  }

  /// Runs `rounds` of them with `run_round(counts, visit)`, which adds what happened to `counts`.
  /// Counts are added to the total after all rounds: the loop holds nothing but the samples and
  /// the two sums over rounds.
  template <class Integrand, class RunRound>
  GMIS_ALWAYS_INLINE void add_rounds(Integrand& f, std::size_t sample_count, std::uint64_t rounds,
                                     RunRound&& run_round) {
    const A samples_of_round = as_factor<A>(sample_count);
    // Copies that never leave this function, so that no call between samples could read them: they
    // stay in registers.
    auto moments = moments_;
    std::uint64_t integrand_evaluations = 0;
    RoundCounts counts;
    for (std::uint64_t round = 0; round < rounds; ++round) {
      Channels sum{};
      run_round(counts, [&](const auto& x, auto denominator, std::size_t) {
        ++integrand_evaluations;
        const F value = value_of(f, x);
        if (!is_finite(value)) [[unlikely]] {
          ++rejected_.non_finite_integrand;
          return;
        }
        add_contribution(value, denominator, sum);
      });
      for (std::size_t c = 0; c < channel_count; ++c) moments[c].add(sum[c] / samples_of_round);
    }
    moments_ = moments;
    integrand_evaluations_ += integrand_evaluations;
    add_cost(rounds * sample_count, counts);
  }

  /// f / denominator in every channel, for rounds that are more than a mean of f / φ: add the
  /// estimate of each with `add_estimate`. All zeros, and the fault counted, when f or the quotient
  /// is not finite.
  template <class D>
  [[nodiscard]] Channels quotient(const F& value, D denominator) noexcept {
    ++integrand_evaluations_;
    Channels result{};
    if (is_finite(value)) [[likely]]
      add_contribution(value, denominator, result);
    else
      ++rejected_.non_finite_integrand;
    return result;
  }
  /// Adds one round: its estimate in every channel, and what it cost.
  void add_estimate(const Channels& estimate, std::uint64_t sample_count, const RoundCounts& counts) noexcept {
    for (std::size_t c = 0; c < channel_count; ++c) moments_[c].add(estimate[c]);
    add_cost(sample_count, counts);
  }
  /// Adds what was spent on no estimate (a warm-up).
  void add_cost(std::uint64_t sample_count, const RoundCounts& counts) noexcept {
    samples_ += sample_count;
    density_evaluations_ += counts.density_evaluations;
    failed_samples_ += counts.failed_samples;
    rejected_.zero_density += counts.zero_density;
    rejected_.non_finite_density += counts.non_finite_density;
  }

  void merge(const EstimateAccumulator& other) noexcept {
    for (std::size_t c = 0; c < moments_.size(); ++c) moments_[c].merge(other.moments_[c]);
    samples_ += other.samples_;
    density_evaluations_ += other.density_evaluations_;
    integrand_evaluations_ += other.integrand_evaluations_;
    failed_samples_ += other.failed_samples_;
    rejected_.non_finite_integrand += other.rejected_.non_finite_integrand;
    rejected_.zero_density += other.rejected_.zero_density;
    rejected_.non_finite_density += other.rejected_.non_finite_density;
    rejected_.non_finite_contribution += other.rejected_.non_finite_contribution;
  }

  /// The estimate from the rounds so far.
  [[nodiscard]] Estimate<Mean> result() const {
    return result([&](std::size_t c) { return moments_[c].mean(); },
                  [&](std::size_t c) { return moments_[c].variance(); });
  }
  /// The estimate from a mean `mean_of(channel)` and a variance of one round
  /// `variance_of(channel)`, where these are not the ones of the rounds.
  template <class MeanOf, class VarianceOf>
  [[nodiscard]] Estimate<Mean> result(MeanOf mean_of, VarianceOf variance_of) const {
    Estimate<Mean> estimate;
    estimate.rounds = moments_[0].count();
    estimate.mean = gather(mean_of);
    if (estimate.rounds > 1) {
      estimate.variance = gather(variance_of);
      estimate.standard_error =
          gather([&](std::size_t c) { return std::sqrt(variance_of(c) / static_cast<A>(estimate.rounds)); });
    }
    estimate.samples = samples_;
    estimate.density_evaluations = density_evaluations_;
    estimate.integrand_evaluations = integrand_evaluations_;
    estimate.failed_samples = failed_samples_;
    estimate.rejected = rejected_;
    return estimate;
  }

 private:
  template <class D>
  void add_contribution(const F& value, D denominator, Channels& sum) noexcept {
    Channels contribution;
    for (std::size_t c = 0; c < channel_count; ++c)
      contribution[c] = ratio<A>(Traits::channel(value, static_cast<int>(c)), denominator);
    A difference = contribution[0] - contribution[0];  // zero for finite numbers alone, so one sum tests all channels
    for (std::size_t c = 1; c < channel_count; ++c) difference += contribution[c] - contribution[c];
    if (difference != A(0)) [[unlikely]] {
      ++rejected_.non_finite_contribution;
      return;
    }
    for (std::size_t c = 0; c < channel_count; ++c) sum[c] += contribution[c];
  }

  template <class Get>
  [[nodiscard]] static Mean gather(Get get) {
    if constexpr (channel_count == 1) {
      return static_cast<Mean>(get(0));
    } else {
      Mean mean;
      for (std::size_t c = 0; c < channel_count; ++c)
        mean[static_cast<typename std::conditional_t<requires { Mean{}.length(); }, int, std::size_t>>(c)] =
            static_cast<A>(get(c));
      return mean;
    }
  }

  std::array<Moments<A>, channel_count> moments_;
  std::uint64_t samples_ = 0;
  std::uint64_t density_evaluations_ = 0;
  std::uint64_t integrand_evaluations_ = 0;
  std::uint64_t failed_samples_ = 0;
  Rejected rejected_;
};

/// Throws std::invalid_argument for no rounds, and for more than 2^62: a negative number that was
/// converted.
constexpr void require_rounds(std::uint64_t rounds) {
  require_argument(rounds > 0, "the number of rounds must be at least 1");
  require_argument(rounds <= std::uint64_t{1} << 62U, "more than 2^62 rounds: was a negative number converted?");
}

/// Adds `rounds` ≥ 1 rounds to `accumulator`: what `estimate` does, for one of several threads or
/// blocks. Give each its own accumulator and source, and merge the accumulators in a fixed order:
/// the sum then depends on no schedule.
template <Selection selection, Weighting weighting, class F, class Integrand, class P, class Source,
          class AllocationType = EqualAllocation>
void add_rounds(EstimateAccumulator<F>& accumulator, Integrand&& f, const P& proposals, std::uint64_t rounds,
                Source&& source, const AllocationType& allocation = {}) {
  if constexpr (detail::explain_arguments<Integrand, P, Source>()) {
    const auto& set = as_proposal_set<std::remove_reference_t<Source>>(proposals);
    using Set = std::remove_cvref_t<decltype(set)>;
    static_assert(std::same_as<F, SummandOf<Integrand, typename Set::Value>>,
                  "the accumulator is for another type than the integrand returns: use gmis::AccumulatorFor");
    require_rounds(rounds);
    allocation.require_fits(set.size(), selection);
    const auto run = [&]<class Bounded>(const Bounded& bounded) GMIS_ALWAYS_INLINE_LAMBDA {
      // An unequal allocation can ask for more samples than there are proposals.
      constexpr std::size_t capacity = AllocationType::is_equal ? capacity_of<Bounded> : dynamic_capacity;
      Workspace<typename Set::Density, capacity> workspace;
      const std::size_t sample_count = allocation.sample_count(bounded.size());
      workspace.prepare(bounded.size(), sample_count);
      accumulator.add_rounds(f, sample_count, rounds, [&](RoundCounts& counts, auto&& visit) GMIS_ALWAYS_INLINE_LAMBDA {
        sample_checked_round<selection, weighting>(bounded, allocation, source, workspace, counts, visit);
      });
    };
    // Sets of few are compiled apart where it is measured to pay: where each sample sums the
    // densities of all.
    constexpr Scheme scheme = scheme_of(selection, weighting);
    if constexpr (AllocationType::is_equal && (scheme == Scheme::R3 || scheme == Scheme::N3))
      with_bound(set, run);
    else
      run(set);
  }
}
/// `add_rounds` for a scheme, run as its cheapest pair.
template <Scheme scheme, class F, class Integrand, class P, class Source, class AllocationType = EqualAllocation>
void add_rounds(EstimateAccumulator<F>& accumulator, Integrand&& f, const P& proposals, std::uint64_t rounds,
                Source&& source, const AllocationType& allocation = {}) {
  constexpr SelectionAndWeighting pair = cheapest_pair(scheme);
  add_rounds<pair.selection, pair.weighting>(accumulator, f, proposals, rounds, source, allocation);
}

/// The accumulator that sums f over samples of `P` drawn from a `Source`.
template <class Integrand, class P, class Source = Philox>
using AccumulatorFor = EstimateAccumulator<SummandOf<
    Integrand, typename std::remove_cvref_t<decltype(as_proposal_set<Source>(std::declval<const P&>()))>::Value>>;

namespace detail {
template <Fault fault, class Integrand, class P, class Source>
struct EstimateFrom {
  using Type = Explained<fault, Estimate<double>>;
};
template <class Integrand, class P, class Source>
struct EstimateFrom<Fault::none, Integrand, P, Source> {
  using Type = Estimate<typename AccumulatorFor<Integrand, P, Source>::Mean>;
};
}  // namespace detail

/// The result of an estimate of f with samples of `P` drawn from a `Source`: an `Estimate` of a
/// number or a spectrum.
template <class Integrand, class P, class Source>
using EstimateOf = typename detail::EstimateFrom<detail::fault_of_arguments<Integrand, P, Source>(), Integrand, P,
                                                 std::remove_reference_t<Source>>::Type;

/// Estimates ∫ f with `rounds` ≥ 1 independent rounds of samples from `proposals`, chosen and
/// weighted as the pair says.
///
/// `f(x)` is a number or a spectrum. `allocation` says how the samples of a round are divided among
/// the proposals (`EqualAllocation{}`: one each). The estimate is unbiased when every point with f
/// ≠ 0 is covered as the scheme needs it; see `needs_full_support` and `check_coverage`. A
/// non-finite value of f is counted, not summed. Allocates once, before the first round, and only
/// when N is not known at compile time or samples are divided unequally (R3 and N3 of up to 16
/// proposals, equally: never).
///
/// Throws std::invalid_argument, before the first round, for an empty set, no rounds, an allocation
/// for another number of proposals, and, with S2 or S3, one that leaves a proposal of positive
/// weight without a sample.
template <Selection selection, Weighting weighting, class Integrand, class P, class Source,
          class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate(Integrand&& f, const P& proposals, std::uint64_t rounds,
                                                        Source&& source, const AllocationType& allocation = {}) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none) {
    AccumulatorFor<Integrand, P, std::remove_reference_t<Source>> accumulator;
    add_rounds<selection, weighting>(accumulator, f, proposals, rounds, source, allocation);
    return accumulator.result();
  } else {
    return {};
  }
}

/// `estimate` for a scheme, run as its cheapest pair.
template <Scheme scheme, class Integrand, class P, class Source, class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate(Integrand&& f, const P& proposals, std::uint64_t rounds,
                                                        Source&& source, const AllocationType& allocation = {}) {
  constexpr SelectionAndWeighting pair = cheapest_pair(scheme);
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none)
    return estimate<pair.selection, pair.weighting>(f, proposals, rounds, source, allocation);
  else
    return {};
}

/// `estimate` for a scheme that is chosen at run time.
template <class Integrand, class P, class Source, class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate(Scheme scheme, Integrand&& f, const P& proposals,
                                                        std::uint64_t rounds, Source&& source,
                                                        const AllocationType& allocation = {}) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none)
    return dispatch(
        scheme, [&](auto fixed) { return estimate<decltype(fixed)::value>(f, proposals, rounds, source, allocation); });
  else
    return {};
}

/// `estimate` for a pair that is chosen at run time.
template <class Integrand, class P, class Source, class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate(Selection selection, Weighting weighting, Integrand&& f,
                                                        const P& proposals, std::uint64_t rounds, Source&& source,
                                                        const AllocationType& allocation = {}) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none)
    return dispatch(selection, weighting, [&](auto fixed_selection, auto fixed_weighting) {
      return estimate<decltype(fixed_selection)::value, decltype(fixed_weighting)::value>(f, proposals, rounds, source,
                                                                                          allocation);
    });
  else
    return {};
}

}  // namespace gmis
