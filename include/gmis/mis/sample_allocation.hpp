#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "gmis/core/random.hpp"
#include "gmis/mis/storage.hpp"

namespace gmis {

/// The paper's case: every proposal has the same weight and a round gives each of them one sample.
struct EqualAllocation {
  static constexpr bool is_equal = true;

  [[nodiscard]] constexpr std::size_t sample_count(std::size_t proposal_count) const noexcept { return proposal_count; }
  [[nodiscard]] constexpr std::size_t proposal_of_slot(std::size_t slot) const noexcept { return slot; }
  template <UniformSource Source>
  [[nodiscard, gnu::always_inline]] constexpr std::size_t draw(Source& source, std::size_t proposal_count) const {
    return proposal_count == 1 ? 0 : uniform_index(source, static_cast<std::uint32_t>(proposal_count));
  }
};

/// Splits `total` samples among proposals in proportion to `weights` (non-negative, any positive sum) by the method of
/// largest remainders; ties go to the lower index. The counts sum to `total`, and each differs from its exact quota by
/// less than one. A pure function, so that every path vertex of one kind gets the same counts.
template <std::floating_point T>
constexpr void apportion(std::span<const T> weights, std::size_t total, std::span<std::uint32_t> counts) noexcept {
  T sum(0);
  for (const T weight : weights) sum += weight;
  if (!(sum > T(0))) return std::fill(counts.begin(), counts.end(), 0U);
  const auto quota = [&](std::size_t k) { return weights[k] / sum * static_cast<T>(total); };
  std::size_t given = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    counts[k] = static_cast<std::uint32_t>(quota(k));
    given += counts[k];
  }
  while (given != total) {
    // Rounding can hand out one too many as well as too few; both are put right where the quota is missed the most.
    const bool too_few = given < total;
    std::size_t worst = 0;
    T worst_error(-2);
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const T shortfall = quota(k) - static_cast<T>(counts[k]);
      const T error = too_few ? shortfall : -shortfall;
      const bool can_change = too_few ? weights[k] > T(0) : counts[k] > 0;
      if (can_change && error > worst_error) {
        worst = k;
        worst_error = error;
      }
    }
    counts[worst] += too_few ? 1U : ~0U;
    given += too_few ? std::size_t{1} : ~std::size_t{0};
  }
}

/// Unequal proposals: weights α_k and `samples` samples a round. S1 draws proposal k with probability α_k, and ψ is
/// Σ α_k q_k; S2 and S3 give it n_k samples, and ψ is Σ n_k q_k / Σ n_k. Build it outside the loop; one with a fixed
/// `Capacity` never allocates and holds up to so many proposals and samples.
template <std::floating_point T, std::size_t Capacity = dynamic_capacity>
class SampleAllocation {
 public:
  static constexpr bool is_equal = false;

  /// From weights (non-negative, any positive sum): n_k are apportioned.
  SampleAllocation(std::span<const T> weights, std::size_t samples) : samples_(samples), proposals_(weights.size()) {
    set_weights([&](std::size_t k) { return weights[k]; });
    counts_.prepare(proposals_);
    apportion<T>(weights, samples, std::span<std::uint32_t>(counts_.data(), proposals_));
    fill_slots();
  }

  /// From counts n_k: then α_k = n_k / Σ n_k.
  explicit SampleAllocation(std::span<const std::uint32_t> counts) : proposals_(counts.size()) {
    counts_.prepare(proposals_);
    for (std::size_t k = 0; k < proposals_; ++k) samples_ += counts_[k] = counts[k];
    set_weights([&](std::size_t k) { return static_cast<T>(counts[k]); });
    fill_slots();
  }

  [[nodiscard]] std::size_t sample_count(std::size_t) const noexcept { return samples_; }
  [[nodiscard]] std::size_t proposal_of_slot(std::size_t slot) const noexcept { return slots_[slot]; }
  [[nodiscard]] T weight(std::size_t k) const noexcept { return weights_[k]; }
  [[nodiscard]] std::uint32_t count(std::size_t k) const noexcept { return counts_[k]; }

  template <UniformSource Source>
  [[nodiscard]] std::size_t draw(Source& source, std::size_t) const {
    const T u = uniform<T>(source);
    const T* const begin = cumulative_.data();
    // The last entry is +infinity for the last positive weight, so that rounding never chooses a zero weight.
    return static_cast<std::size_t>(std::upper_bound(begin, begin + proposals_, u) - begin);
  }

 private:
  template <class WeightOf>
  void set_weights(WeightOf weight_of) {
    weights_.prepare(proposals_);
    cumulative_.prepare(proposals_);
    T sum(0);
    for (std::size_t k = 0; k < proposals_; ++k) sum += weight_of(k);
    T running(0);
    std::size_t last_positive = 0;
    for (std::size_t k = 0; k < proposals_; ++k) {
      weights_[k] = weight_of(k) / sum;
      running += weights_[k];
      cumulative_[k] = running;
      if (weights_[k] > T(0)) last_positive = k;
    }
    for (std::size_t k = last_positive; k < proposals_; ++k) cumulative_[k] = std::numeric_limits<T>::infinity();
  }
  void fill_slots() {
    slots_.prepare(samples_);
    std::size_t slot = 0;
    for (std::size_t k = 0; k < proposals_; ++k)
      for (std::uint32_t i = 0; i < counts_[k]; ++i) slots_[slot++] = static_cast<std::uint32_t>(k);
  }

  std::size_t samples_ = 0;
  std::size_t proposals_;
  Storage<T, Capacity> weights_, cumulative_;
  Storage<std::uint32_t, Capacity> counts_, slots_;
};

}  // namespace gmis
