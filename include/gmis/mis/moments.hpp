#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "gmis/core/compensated_sum.hpp"
#include "gmis/core/spectrum.hpp"

namespace gmis {

/// What sums are kept in: long double for long double, else double.
template <std::floating_point T>
using AccumulatorOf = std::conditional_t<std::same_as<T, long double>, long double, double>;

/// A spectrum with channels of type A, to return means and variances in: A itself for one channel, a GLM vector for a
/// GLM vector, else a std::array.
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

/// Mean and variance of a stream of numbers. The mean is a compensated sum, the sum of squared deviations is updated
/// from the running mean (Welford 1962), so that neither loses digits to cancellation or to the number of terms.
template <std::floating_point A>
class Moments {
 public:
  void add(A value) noexcept {
    ++count_;
    sum_ += value;
    const A deviation = value - running_mean_;
    running_mean_ += deviation / static_cast<A>(count_);
    squared_deviations_ += deviation * (value - running_mean_);
  }

  /// Adds all that `other` has seen (Chan, Golub, LeVeque 1979).
  void merge(const Moments& other) noexcept {
    if (other.count_ == 0) return;
    const A own_count = static_cast<A>(count_);
    const A other_count = static_cast<A>(other.count_);
    const A difference = other.running_mean_ - running_mean_;
    const A other_share = other_count / (own_count + other_count);
    running_mean_ += difference * other_share;
    squared_deviations_ += other.squared_deviations_ + difference * difference * own_count * other_share;
    sum_ += other.sum_;
    count_ += other.count_;
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  /// 0 when nothing was added.
  [[nodiscard]] A mean() const noexcept { return count_ == 0 ? A(0) : sum_.value() / static_cast<A>(count_); }
  /// The unbiased sample variance; `count()` must be at least 2.
  [[nodiscard]] A variance() const noexcept { return squared_deviations_ / static_cast<A>(count_ - 1); }

 private:
  std::uint64_t count_ = 0;
  CompensatedSum<A> sum_;
  A running_mean_ = A(0);
  A squared_deviations_ = A(0);
};

}  // namespace gmis
