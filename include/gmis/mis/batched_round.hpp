#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/estimate.hpp"

/// \file
/// N3 over batches of samples: a batch is drawn, then one proposal after the other is evaluated at
/// all samples of the batch, in a loop that compilers turn into vector instructions where a density
/// has neither calls nor branches. Any set with `pdf` serves as it is: in that loop the proposal
/// stays and the sample changes. Samples, sums and results have the same bits as those of
/// `estimate<Scheme::N3>`.

namespace gmis {

/// Samples that are evaluated together.
inline constexpr std::size_t batch_size = 16;

/// A set that rounds can work through in batches: one density at a time, not in logarithms, samples
/// that can be stored.
template <class Set>
concept BatchableSet = SetHasPdf<Set> && !is_log_set<Set> && std::default_initializable<typename Set::Value>;

namespace detail {

/// The samples of a batch, what they are divided by, and the densities of one proposal at all of
/// them.
template <class Set>
class Batch {
  using T = typename Set::Density;

 public:
  void clear() noexcept { size_ = 0; }
  void add(const typename Set::Value& x, std::size_t index) {
    x_[size_] = x;
    index_[size_++] = index;
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const typename Set::Value& x(std::size_t j) const noexcept { return x_[j]; }
  [[nodiscard]] std::size_t index(std::size_t j) const noexcept { return index_[j]; }
  [[nodiscard]] T own(std::size_t j) const noexcept { return own_[j]; }
  /// `MixtureSum::over` for sample j.
  [[nodiscard]] T mixture_over(std::size_t j, T normaliser) const noexcept {
    return least_[j] < T(0) ? std::numeric_limits<T>::quiet_NaN() : sums_[0][j] / normaliser;
  }

  /// Σ c_i q_i at every sample, added up in the order of `MixtureSum`: eight sums side by side for
  /// many equal ones.
  template <class AllocationType>
  void evaluate(const Set& set, const AllocationType& allocation) {
    if (size_ == batch_size)
      evaluate_all(set, allocation, std::integral_constant<std::size_t, batch_size>{});
    else
      evaluate_all(set, allocation, size_);
  }

 private:
  static constexpr std::size_t lanes = 8;

  template <class AllocationType, class Size>
  GMIS_ALWAYS_INLINE void evaluate_all(const Set& set, const AllocationType& allocation, Size size) {
    const std::size_t n = set.size();
    const bool in_lanes = AllocationType::is_equal && n > few_densities;
    const std::size_t used = in_lanes ? lanes : 1, in_blocks = in_lanes ? n / lanes * lanes : 0;
    for (std::size_t lane = 0; lane < used; ++lane)
      for (std::size_t j = 0; j < size; ++j) sums_[lane][j] = T(0);
    for (std::size_t j = 0; j < size; ++j) least_[j] = T(0);
    std::size_t next = 0;  // the first sample whose own density is not known yet; their proposals come in order
    for (std::size_t i = 0; i < in_blocks; ++i)
      add_proposal(set, i, sums_[i % lanes], size, next, [](T q) { return q; });
    for (std::size_t half = lanes / 2; half > 0 && in_lanes; half /= 2)
      for (std::size_t lane = 0; lane < half; ++lane)
        for (std::size_t j = 0; j < size; ++j) sums_[lane][j] += sums_[lane + half][j];
    for (std::size_t i = in_blocks; i < n; ++i) {
      if constexpr (AllocationType::is_equal) {
        add_proposal(set, i, sums_[0], size, next, [](T q) { return q; });
      } else if (allocation.count(i) > 0) {
        const T count = static_cast<T>(allocation.count(i));
        add_proposal(set, i, sums_[0], size, next, [count](T q) { return count * q; });
      }
    }
  }

  template <class Size, class Times>
  GMIS_ALWAYS_INLINE void add_proposal(const Set& set, std::size_t i, std::array<T, batch_size>& sums, Size size,
                                       std::size_t& next, Times times) {
    for (std::size_t j = 0; j < size; ++j) {
      const T density = set.pdf(i, x_[j]);
      density_[j] = density;
      sums[j] += times(density);
      least_[j] = density < least_[j] ? density : least_[j];
    }
    for (; next < size && index_[next] == i; ++next) own_[next] = density_[next];
  }

  std::array<typename Set::Value, batch_size> x_;
  std::array<T, batch_size> density_, own_, least_;
  std::array<std::array<T, batch_size>, lanes> sums_;
  std::array<std::size_t, batch_size> index_;
  std::size_t size_ = 0;
};

}  // namespace detail

/// `sample_round<Scheme::N3>`, in batches: calls `visit(x, denominator, index)` for the same
/// samples in the same order. Adds what happened to `counts`. The allocation must fit the set.
template <class Set, class AllocationType, class Source, class Visit>
requires BatchableSet<Set>
void sample_round_in_batches(const Set& set, const AllocationType& allocation, Source& source, RoundCounts& counts,
                             Visit&& visit) {
  using T = typename Set::Density;
  const std::size_t samples = allocation.sample_count(set.size());
  const T normaliser = as_factor<T>(samples);
  std::size_t used = set.size();  // proposals with samples: the densities that a sample costs
  if constexpr (!AllocationType::is_equal) {
    used = 0;
    for (std::size_t i = 0; i < set.size(); ++i) used += allocation.count(i) > 0 ? 1 : 0;
  }
  detail::Batch<Set> batch;
  for (std::size_t n = 0; n < samples;) {
    batch.clear();
    for (const std::size_t end = std::min(samples, n + batch_size); n < end; ++n) {
      const std::size_t index = allocation.proposal_of_slot(n);
      const auto result = set.sample(index, source);
      if constexpr (SampleResult<std::remove_cvref_t<decltype(result)>>::can_fail) {
        if (result)
          batch.add(*result, index);
        else
          ++counts.failed_samples;
      } else {
        batch.add(result, index);
      }
    }
    batch.evaluate(set, allocation);
    counts.density_evaluations += batch.size() * used;
    for (std::size_t j = 0; j < batch.size(); ++j) {
      const T own = batch.own(j), denominator = batch.mixture_over(j, normaliser);
      if (is_usable(own, denominator)) [[likely]] {
        visit(batch.x(j), denominator, batch.index(j));
      } else {
        count_unusable(own, denominator, counts);
      }
    }
  }
}

/// `estimate<Scheme::N3>`, in batches: the same result, bit for bit, in less time where densities
/// have no calls.
template <class Integrand, class P, class Source, class AllocationType = EqualAllocation>
[[nodiscard]] EstimateOf<Integrand, P, Source> estimate_in_batches(Integrand&& f, const P& proposals,
                                                                   std::uint64_t rounds, Source&& source,
                                                                   const AllocationType& allocation = {}) {
  if constexpr (detail::fault_of_arguments<Integrand, P, Source>() == detail::Fault::none) {
    const auto& set = as_proposal_set<std::remove_reference_t<Source>>(proposals);
    using Set = std::remove_cvref_t<decltype(set)>;
    static_assert(BatchableSet<Set>,
                  "batches need a set with `pdf(i, x)`, and samples with a default constructor: use gmis::estimate");
    require_rounds(rounds);
    allocation.require_fits(set.size(), Selection::S3);
    AccumulatorFor<Integrand, P, std::remove_reference_t<Source>> accumulator;
    accumulator.add_rounds(f, allocation.sample_count(set.size()), rounds, [&](RoundCounts& counts, auto&& visit) {
      sample_round_in_batches(set, allocation, source, counts, visit);
    });
    return accumulator.result();
  } else {
    return {};
  }
}

}  // namespace gmis
