#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "gmis/core/argument_error.hpp"
#include "gmis/core/attributes.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/apportion.hpp"
#include "gmis/mis/scheme.hpp"
#include "gmis/mis/storage.hpp"

namespace gmis {

/// The paper's case: every proposal has the same weight and a round gives each of them one sample.
struct EqualAllocation {
  /// All proposals have one share.
  static constexpr bool is_equal = true;

  /// Samples of a round: one for each proposal.
  [[nodiscard]] constexpr std::size_t sample_count(std::size_t proposal_count) const noexcept { return proposal_count; }
  /// The proposal that makes the sample of this slot, in schemes that do not draw it.
  [[nodiscard]] constexpr std::size_t proposal_of_slot(std::size_t slot) const noexcept { return slot; }
  /// n_i = 1.
  [[nodiscard]] constexpr std::uint32_t count(std::size_t) const noexcept { return 1; }
  /// Throws std::invalid_argument for an empty set of proposals.
  constexpr void require_fits(std::size_t proposal_count, Selection) const {
    require_argument(proposal_count > 0, "the set of proposals is empty: give it at least one proposal");
  }
  /// A proposal, each with the same probability.
  template <UniformSource Source>
  [[nodiscard]] GMIS_ALWAYS_INLINE constexpr std::size_t draw(Source& source, std::size_t proposal_count) const {
    return proposal_count == 1 ? 0 : uniform_index(source, static_cast<std::uint32_t>(proposal_count));
  }
};

/// A range of numbers: an array, a vector, a span, …
template <class R>
concept NumberRange = requires(const R& numbers) {
  std::begin(numbers);
  std::end(numbers);
  std::size(numbers);
}
&&std::is_arithmetic_v<std::remove_cvref_t<decltype(*std::begin(std::declval<const R&>()))>>;
template <class R>
concept CountRange =
    NumberRange<R> && std::integral<std::remove_cvref_t<decltype(*std::begin(std::declval<const R&>()))>>;

/// How the samples of a round are divided among unequal proposals: weights α_i and sample counts
/// n_i. S1 draws proposal i with probability α_i, and ψ is Σ α_i q_i; S2 and S3 give it n_i
/// samples, and ψ is Σ n_i q_i / Σ n_i. Build it outside the loop; one with a fixed `Capacity`
/// never allocates and holds at most `Capacity` proposals and `Capacity` samples.
///
/// A proposal of weight 0 is left out. Any other gets a sample: where there are fewer samples in a
/// round than proposals of positive weight, only S1 can use the allocation, and S2 and S3 reject
/// it.
template <std::floating_point T, std::size_t Capacity = dynamic_capacity>
class SampleAllocation {
 public:
  /// Proposals may differ.
  static constexpr bool is_equal = false;

  /// From weights, which need not sum to one, and the samples of a round: the n_i are
  /// `apportion_to_all`'s. Throws std::invalid_argument when a weight is negative or not finite,
  /// all are zero, or `samples` is 0.
  template <NumberRange Weights>
  SampleAllocation(const Weights& weights, std::size_t samples)
      : SampleAllocation(FromWeights{}, std::begin(weights), std::size(weights), samples) {}
  /// From a list of weights.
  SampleAllocation(std::initializer_list<T> weights, std::size_t samples)
      : SampleAllocation(FromWeights{}, weights.begin(), weights.size(), samples) {}

  /// From counts n_i: then α_i = n_i / Σ n_i. Throws std::invalid_argument when a count is negative
  /// or all are zero.
  template <CountRange Counts>
  explicit SampleAllocation(const Counts& counts)
      : SampleAllocation(FromCounts{}, std::begin(counts), std::size(counts)) {}
  /// From a list of counts.
  explicit SampleAllocation(std::initializer_list<std::uint32_t> counts)
      : SampleAllocation(FromCounts{}, counts.begin(), counts.size()) {}

  [[nodiscard]] std::size_t proposal_count() const noexcept { return proposals_; }
  /// Samples of a round, Σ n_i.
  [[nodiscard]] std::size_t sample_count(std::size_t) const noexcept { return samples_; }
  /// The proposal that makes the sample of this slot, in schemes that do not draw it.
  [[nodiscard]] std::size_t proposal_of_slot(std::size_t slot) const noexcept { return slots_[slot]; }
  /// α_i, which sum to one.
  [[nodiscard]] T weight(std::size_t i) const noexcept { return weights_[i]; }
  /// n_i.
  [[nodiscard]] std::uint32_t count(std::size_t i) const noexcept { return counts_[i]; }

  /// Throws std::invalid_argument unless the allocation is for `proposal_count` proposals, and
  /// gives a sample to each that has a weight or `selection` draws them at random.
  void require_fits(std::size_t proposal_count, Selection selection) const {
    require_argument(proposals_ == proposal_count,
                     "the SampleAllocation is for another number of proposals: give it one weight, or count, for each "
                     "proposal of the set");
    require_argument(
        selection == Selection::S1 || reaches_all_,
        "a proposal has a positive weight and no sample: ask the SampleAllocation for at least one sample for "
        "each, or select at random (S1: R1, R2, R3)");
  }

  /// A proposal, i with the probability α_i.
  template <UniformSource Source>
  [[nodiscard]] std::size_t draw(Source& source, std::size_t) const {
    const T u = uniform<T>(source);
    const T* const begin = cumulative_.data();
    // The last entry is +infinity for the last positive weight, so that rounding never chooses a
    // zero weight.
    return static_cast<std::size_t>(std::upper_bound(begin, begin + proposals_, u) - begin);
  }

 private:
  struct FromWeights {};
  struct FromCounts {};

  template <class Iterator>
  SampleAllocation(FromWeights, Iterator weights, std::size_t proposals, std::size_t samples)
      : samples_(samples), proposals_(proposals) {
    weights_.prepare(proposals_);
    counts_.prepare(proposals_);
    std::size_t positive = 0;
    for (std::size_t i = 0; i < proposals_; ++i, ++weights) {
      weights_[i] = static_cast<T>(*weights);
      if (weights_[i] > T(0)) ++positive;
    }
    require_argument(samples > 0, "a round of no samples: ask the SampleAllocation for at least one");
    const std::span<const T> all(weights_.data(), proposals_);
    const std::span<std::uint32_t> counts(counts_.data(), proposals_);
    reaches_all_ = samples >= positive;
    if (reaches_all_)
      apportion_to_all<T>(all, samples, counts);
    else
      apportion<T>(all, samples, counts);
    normalise_weights();
    fill_slots();
  }

  template <class Iterator>
  SampleAllocation(FromCounts, Iterator counts, std::size_t proposals) : proposals_(proposals) {
    weights_.prepare(proposals_);
    counts_.prepare(proposals_);
    for (std::size_t i = 0; i < proposals_; ++i, ++counts) {
      require_argument(std::in_range<std::uint32_t>(*counts), "a sample count is negative or 2^32 or more");
      counts_[i] = static_cast<std::uint32_t>(*counts);
      samples_ += counts_[i];
      weights_[i] = static_cast<T>(counts_[i]);
    }
    require_argument(samples_ > 0, "all sample counts are zero: give at least one proposal a sample");
    require_argument(samples_ <= std::numeric_limits<std::uint32_t>::max(), "a round of 2^32 samples or more");
    normalise_weights();
    fill_slots();
  }

  void normalise_weights() {
    cumulative_.prepare(proposals_);
    const T largest = *std::max_element(weights_.data(), weights_.data() + proposals_);
    T sum(0);  // relative to the largest: weights near the largest number do not overflow
    for (std::size_t i = 0; i < proposals_; ++i) sum += weights_[i] / largest;
    T running(0);
    std::size_t last_positive = 0;
    for (std::size_t i = 0; i < proposals_; ++i) {
      weights_[i] = weights_[i] / largest / sum;
      running += weights_[i];
      cumulative_[i] = running;
      if (weights_[i] > T(0)) last_positive = i;
    }
    for (std::size_t i = last_positive; i < proposals_; ++i) cumulative_[i] = std::numeric_limits<T>::infinity();
  }
  void fill_slots() {
    slots_.prepare(samples_);
    std::size_t slot = 0;
    for (std::size_t i = 0; i < proposals_; ++i)
      for (std::uint32_t n = 0; n < counts_[i]; ++n) slots_[slot++] = static_cast<std::uint32_t>(i);
  }

  std::size_t samples_ = 0;
  std::size_t proposals_;
  bool reaches_all_ = true;  // every positive weight has a sample
  Storage<T, Capacity> weights_, cumulative_;
  Storage<std::uint32_t, Capacity> counts_, slots_;
};

template <NumberRange Weights>
SampleAllocation(const Weights&, std::size_t) -> SampleAllocation<
    std::conditional_t<std::is_floating_point_v<std::remove_cvref_t<decltype(*std::begin(std::declval<Weights&>()))>>,
                       std::remove_cvref_t<decltype(*std::begin(std::declval<Weights&>()))>, double>>;
template <std::floating_point T>
SampleAllocation(std::initializer_list<T>, std::size_t) -> SampleAllocation<T>;
template <CountRange Counts>
SampleAllocation(const Counts&) -> SampleAllocation<double>;
SampleAllocation(std::initializer_list<std::uint32_t>)->SampleAllocation<double>;

}  // namespace gmis
