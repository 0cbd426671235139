#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "gmis/core/compensated_sum.hpp"
#include "gmis/core/spectrum.hpp"

namespace gmis {

/// The type that sums are kept in: long double for long double, else double.
template <std::floating_point T>
using AccumulatorOf = std::conditional_t<std::same_as<T, long double>, long double, double>;

/// A spectrum with channels of type A, to return means and variances in: A itself for one channel,
/// a GLM vector for a GLM vector, else a std::array.
template <class S, class A>
struct Rebound {
  using Type = std::array<A, static_cast<std::size_t>(SpectrumTraits<S>::channel_count)>;
};
template <std::floating_point T, class A>
struct Rebound<T, A> {
  using Type = A;
};
template <int N, std::floating_point T, glm::qualifier Q, class A>
struct Rebound<glm::vec<N, T, Q>, A> {
  using Type = glm::vec<N, A, Q>;
};

/// The type of the mean of values of type S.
template <Spectrum S>
using MeanOf = typename Rebound<S, AccumulatorOf<ScalarOf<S>>>::Type;

/// Mean and variance of a stream of numbers. Numbers are summed in blocks, as differences from the
/// mean so far (from the first number, in the first block), and blocks are merged into compensated
/// sums: nothing is lost to cancellation or to the number of terms, and a number costs two
/// additions and a multiplication. Where squares of differences exceed the largest number, the
/// variance is infinite; the mean needs differences of at most 1/256 of that number.
template <std::floating_point A>
class Moments {
 public:
  void add(A value) noexcept {
    if (block_count_ == 0) shift_ = count_ == 0 ? value : mean();
    const A difference = value - shift_;
    block_sum_ += difference;
    block_squares_ += difference * difference;
    if (++block_count_ == block_size) close_block();
  }

  /// Adds all that `other` has seen.
  void merge(Moments other) noexcept {
    other.close_block();
    close_block();
    merge_closed(other.count_, other.mean_of_closed(), other.squared_deviations_);
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_ + block_count_; }
  /// 0 when nothing was added.
  [[nodiscard]] A mean() const noexcept { return closed().mean_of_closed(); }
  /// The unbiased sample variance; `count()` must be at least 2.
  [[nodiscard]] A variance() const noexcept { return closed().squared_deviations_ / static_cast<A>(count() - 1); }

 private:
  static constexpr std::uint64_t block_size = 256;

  [[nodiscard]] Moments closed() const noexcept {
    Moments result = *this;
    result.close_block();
    return result;
  }
  [[nodiscard]] A mean_of_closed() const noexcept { return count_ == 0 ? A(0) : mean_.value(); }

  void close_block() noexcept {
    if (block_count_ == 0) return;
    const A n = static_cast<A>(block_count_);
    const A offset = block_sum_ / n;
    // The difference of two infinities is no number.
    constexpr A infinity = std::numeric_limits<A>::infinity();
    const A squared_deviations =
        block_squares_ < infinity ? std::max(A(0), block_squares_ - block_sum_ * offset) : infinity;
    const std::uint64_t block_count = std::exchange(block_count_, 0);
    block_sum_ = block_squares_ = A(0);
    merge_closed(block_count, shift_ + offset, squared_deviations);
  }

  // Chan, Golub, LeVeque 1979.
  void merge_closed(std::uint64_t other_count, A other_mean, A other_squared_deviations) noexcept {
    if (other_count == 0) return;
    if (count_ == 0) {
      mean_ += other_mean;
      squared_deviations_ = other_squared_deviations;
      count_ = other_count;
      return;
    }
    const A own_count = static_cast<A>(count_);
    const A difference = other_mean - mean_.value();
    const A other_share = static_cast<A>(other_count) / (own_count + static_cast<A>(other_count));
    mean_ += difference * other_share;
    squared_deviations_ += other_squared_deviations + difference * difference * own_count * other_share;
    count_ += other_count;
  }

  std::uint64_t count_ = 0;  // in closed blocks
  CompensatedSum<A> mean_;
  A squared_deviations_ = A(0);
  std::uint64_t block_count_ = 0;
  A shift_ = A(0);
  A block_sum_ = A(0);
  A block_squares_ = A(0);
};

}  // namespace gmis
