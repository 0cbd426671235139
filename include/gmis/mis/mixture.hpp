#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "gmis/core/attributes.hpp"
#include "gmis/mis/proposal_set.hpp"

/// \file
/// Densities of a set at one point and weighted sums of them, in one notation for plain densities
/// and for logarithms.

namespace gmis {

/// The denominator of a sample: T, or LogDensity<T> for a set that works with logarithms.
template <class Set>
using Denominator = std::conditional_t<is_log_set<Set>, LogDensity<typename Set::Density>, typename Set::Density>;

/// A count as a factor of densities. Processors convert signed numbers in one step and unsigned
/// ones in five.
template <std::floating_point T>
[[nodiscard]] constexpr T as_factor(std::size_t count) noexcept {
  return static_cast<T>(static_cast<std::ptrdiff_t>(count));
}

/// More densities than this are evaluated and summed in functions of their own: within the long
/// body of a round, compilers run out of registers.
inline constexpr std::size_t few_densities = 16;

template <std::floating_point T>
struct SumAndLeast {
  T sum, least;
};

/// The sum of `count` densities and the least of them and 0, in eight sums side by side, which are
/// faster and more exact than one.
template <std::floating_point T>
[[nodiscard]] GMIS_NEVER_INLINE SumAndLeast<T> sum_of_many(const T* densities, std::size_t count) noexcept {
  constexpr std::size_t lanes = 8;
  T sums[lanes] = {}, least[lanes] = {};
  const std::size_t blocks = count / lanes;
  for (std::size_t block = 0; block < blocks; ++block)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const T density = densities[block * lanes + lane];
      sums[lane] += density;
      least[lane] = density < least[lane] ? density : least[lane];
    }
  for (std::size_t half = lanes / 2; half > 0; half /= 2)
    for (std::size_t lane = 0; lane < half; ++lane) {
      sums[lane] += sums[lane + half];
      least[lane] = least[lane + half] < least[lane] ? least[lane + half] : least[lane];
    }
  for (std::size_t i = blocks * lanes; i < count; ++i) {
    sums[0] += densities[i];
    least[0] = densities[i] < least[0] ? densities[i] : least[0];
  }
  return {sums[0], least[0]};
}

/// Σ c_i q_i, c_i > 0, and then over a normaliser: NaN when a density was negative, even if the sum
/// is positive.
template <std::floating_point T, bool in_logarithms>
class MixtureSum {
 public:
  void add(T density) noexcept {
    sum_ += density;
    least_ = density < least_ ? density : least_;
  }
  void add(T density, T coefficient) noexcept {
    sum_ += coefficient * density;
    least_ = density < least_ ? density : least_;
  }
  /// Adds densities to an empty sum.
  void add_many(const T* densities, std::size_t count) noexcept {
    const auto [sum, least] = sum_of_many(densities, count);
    sum_ = sum;
    least_ = least;
  }
  [[nodiscard]] T over(T normaliser) const noexcept {
    return least_ < T(0) ? std::numeric_limits<T>::quiet_NaN() : sum_ / normaliser;
  }

 private:
  T sum_{0};
  T least_{0};
};

template <std::floating_point T>
class MixtureSum<T, true> {
 public:
  void add(T log_density) noexcept { sum_.add(log_density); }
  void add(T log_density, T coefficient) noexcept { sum_.add(log_density, coefficient); }
  void add_many(const T* log_densities, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) add(log_densities[i]);
  }
  [[nodiscard]] LogDensity<T> over(T normaliser) const noexcept { return {sum_.log_over(normaliser)}; }

 private:
  LogSum<T> sum_;
};

template <std::floating_point T>
[[nodiscard]] constexpr bool is_finite_number(T x) noexcept {
  return x >= std::numeric_limits<T>::lowest() && x <= std::numeric_limits<T>::max();
}

enum class DensityState : unsigned char { usable, zero, non_finite };

/// Whether a sample can be divided by this density; for logarithms, whether its logarithm is a
/// number.
template <std::floating_point T>
[[nodiscard]] constexpr DensityState state_of(T density) noexcept {
  if (density > T(0)) return density <= std::numeric_limits<T>::max() ? DensityState::usable : DensityState::non_finite;
  return density == T(0) ? DensityState::zero : DensityState::non_finite;
}
template <std::floating_point T>
[[nodiscard]] constexpr DensityState state_of(LogDensity<T> density) noexcept {
  if (is_finite_number(density.log)) return DensityState::usable;
  return density.log == -std::numeric_limits<T>::infinity() ? DensityState::zero : DensityState::non_finite;
}

/// Positive and finite. The bit patterns of positive finite numbers are consecutive, so that for
/// float and double one comparison of integers answers.
template <std::floating_point T>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr bool is_positive_and_finite(T x) noexcept {
  if constexpr (std::numeric_limits<T>::is_iec559 && sizeof(T) == sizeof(std::uint64_t)) {
    return std::bit_cast<std::uint64_t>(x) - 1U < std::bit_cast<std::uint64_t>(std::numeric_limits<T>::infinity()) - 1U;
  } else if constexpr (std::numeric_limits<T>::is_iec559 && sizeof(T) == sizeof(std::uint32_t)) {
    return std::bit_cast<std::uint32_t>(x) - 1U < std::bit_cast<std::uint32_t>(std::numeric_limits<T>::infinity()) - 1U;
  } else {
    return x > T(0) && x <= std::numeric_limits<T>::max();
  }
}

/// Whether a sample can be used: its own density positive, its denominator positive and finite. (A
/// finite mixture has no infinite part, and one with a negative part is NaN, so nothing more needs
/// to be asked.)
template <std::floating_point T>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr bool is_usable(T own, T denominator) noexcept {
  return own > T(0) && is_positive_and_finite(denominator);
}
template <std::floating_point T>
[[nodiscard]] GMIS_ALWAYS_INLINE constexpr bool is_usable(T own_and_denominator) noexcept {
  return is_positive_and_finite(own_and_denominator);
}
template <std::floating_point T>
[[nodiscard]] constexpr bool is_usable(LogDensity<T> own_and_denominator) noexcept {
  return is_finite_number(own_and_denominator.log);
}
template <std::floating_point T>
[[nodiscard]] constexpr bool is_usable(LogDensity<T> own, LogDensity<T> denominator) noexcept {
  return is_finite_number(own.log) && is_finite_number(denominator.log);
}

/// Small objects are passed and held by value: one whose address is never taken can stay in
/// registers.
template <class Argument>
using PassedAs = std::conditional_t<std::is_trivially_copyable_v<Argument> && sizeof(Argument) <= 2 * sizeof(void*),
                                    Argument, const Argument&>;

/// The densities of a set at one point x. One at a time where the set can, so that what a scheme
/// does not need is not evaluated; a set that only evaluates all at once does so here.
template <class Set>
class DensitiesAt {
 public:
  using T = typename Set::Density;
  static constexpr bool one_at_a_time = SetHasPdf<Set> || SetHasLogPdf<Set>;
  static constexpr bool all_at_once = SetHasPdfs<Set> || SetHasLogPdfs<Set>;

  /// `buffer`: room for `set.size()` numbers.
  GMIS_ALWAYS_INLINE DensitiesAt(const Set& set, const typename Set::Value& x, T* buffer)
      : set_(set), x_(x), buffer_(buffer) {
    if constexpr (!one_at_a_time) evaluate_all();
  }

  /// Says that all densities will be asked for, so that the set may evaluate them together.
  void expect_all() {
    if constexpr (one_at_a_time && all_at_once) {
      evaluate_all();
      have_all_ = true;
    }
  }

  /// The density, or its logarithm, of proposal i.
  [[nodiscard]] GMIS_ALWAYS_INLINE T operator[](std::size_t i) {
    count(1);
    return uncounted(i);
  }

  /// `operator[]` without counting: the caller counts with `count`, so that a sum of many densities
  /// need not carry a counter along.
  [[nodiscard]] GMIS_ALWAYS_INLINE T uncounted(std::size_t i) const {
    if constexpr (!one_at_a_time) {
      return buffer_[i];
    } else {
      if constexpr (all_at_once)
        if (have_all_) return buffer_[i];
      if constexpr (is_log_set<Set>)
        return set_.log_pdf(i, x_);
      else
        return set_.pdf(i, x_);
    }
  }
  /// Says that `evaluations` densities were asked for. (Does not count where all were evaluated at
  /// once.)
  GMIS_ALWAYS_INLINE void count(std::size_t evaluations) noexcept {
    if constexpr (one_at_a_time)
      if (!have_all_) evaluations_ += evaluations;
  }

  /// `uncounted`, and kept for `kept(i)` until the next point.
  [[nodiscard]] GMIS_ALWAYS_INLINE T keep(std::size_t i) {
    const T density = uncounted(i);
    if constexpr (one_at_a_time) buffer_[i] = density;
    return density;
  }
  [[nodiscard]] T kept(std::size_t i) const noexcept { return buffer_[i]; }
  /// The mixture of all with equal coefficients; all are kept and counted.
  [[nodiscard]] GMIS_ALWAYS_INLINE MixtureSum<T, is_log_set<Set>> mixture_of_all() {
    const std::size_t size = set_.size();
    count(size);
    if constexpr (few_densities < capacity_of<Set>)
      if (size > few_densities) return has_all() ? mixture_of_kept(buffer_, size) : keep_and_mix(set_, x_, buffer_);
    if (!has_all())
      for (std::size_t i = 0; i < size; ++i) buffer_[i] = uncounted(i);
    MixtureSum<T, is_log_set<Set>> mixture;
    for (std::size_t i = 0; i < size; ++i) mixture.add(buffer_[i]);
    return mixture;
  }

  /// How many densities have been evaluated.
  [[nodiscard]] std::size_t evaluations() const noexcept { return evaluations_; }

  /// True when all were evaluated at once, and so are kept already.
  [[nodiscard]] bool has_all() const noexcept {
    if constexpr (!one_at_a_time)
      return true;
    else
      return all_at_once && have_all_;
  }

  [[nodiscard]] static Denominator<Set> as_denominator(T density) noexcept {
    if constexpr (is_log_set<Set>)
      return {density};
    else
      return density;
  }

 private:
  void evaluate_all() {
    const std::span<T> out(buffer_, set_.size());
    if constexpr (is_log_set<Set>)
      set_.log_pdfs(x_, out);
    else
      set_.pdfs(x_, out);
    evaluations_ += out.size();
  }

  [[nodiscard]] GMIS_NEVER_INLINE static MixtureSum<T, is_log_set<Set>> keep_and_mix(PassedAs<Set> set,
                                                                                     PassedAs<typename Set::Value> x,
                                                                                     T* buffer) {
    const std::size_t size = set.size();
    if constexpr (one_at_a_time)
      for (std::size_t i = 0; i < size; ++i) {
        if constexpr (is_log_set<Set>)
          buffer[i] = set.log_pdf(i, x);
        else
          buffer[i] = set.pdf(i, x);
      }
    return mixture_of_kept(buffer, size);
  }
  [[nodiscard]] static MixtureSum<T, is_log_set<Set>> mixture_of_kept(const T* densities, std::size_t size) noexcept {
    MixtureSum<T, is_log_set<Set>> mixture;
    mixture.add_many(densities, size);
    return mixture;
  }

  const Set& set_;
  const typename Set::Value& x_;
  T* buffer_;
  std::size_t evaluations_ = 0;
  bool have_all_ = false;
};

}  // namespace gmis
