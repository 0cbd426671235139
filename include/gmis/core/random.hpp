#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace gmis {

/// What the library draws from: every `std::uniform_random_bit_generator`, so every engine of <random> (also
/// `std::default_random_engine`, `std::minstd_rand`, `std::ranlux48`, `std::random_device`), the `Philox` below, or a class of
/// one's own. One whose words have 32 or 64 full bits (`Philox`, `std::mt19937`, `std::mt19937_64`) is used as it is; the bits
/// of any other are put together, and the words that would make them uneven are drawn again.
template <class S>
concept UniformSource = std::invocable<S&> && std::unsigned_integral<std::invoke_result_t<S&>> && requires {
  { S::min() } -> std::same_as<std::invoke_result_t<S&>>;
  { S::max() } -> std::same_as<std::invoke_result_t<S&>>;
  requires std::bool_constant<(S::min() < S::max())>::value;
};

/// True when a word of the source is 64 uniform bits.
template <UniformSource S>
inline constexpr bool has_64_bit_words = S::min() == 0 && S::max() == std::numeric_limits<std::uint64_t>::max();

/// 32 uniform bits. From a source of 32 full bits, its next word.
template <UniformSource S>
[[nodiscard]] constexpr std::uint32_t uniform_word(S& source) {
  constexpr std::uint64_t last = static_cast<std::uint64_t>(S::max()) - static_cast<std::uint64_t>(S::min());
  const auto next = [&source]() -> std::uint64_t { return static_cast<std::uint64_t>(source() - S::min()); };
  if constexpr (last == std::numeric_limits<std::uint32_t>::max()) {
    return static_cast<std::uint32_t>(next());
  } else if constexpr (last == std::numeric_limits<std::uint64_t>::max()) {
    return static_cast<std::uint32_t>(next() >> 32U);
  } else {
    // Each word gives 16, 8, 4, 2 or 1 bits, or all 32: as many as it has. They number equal parts of its range.
    constexpr unsigned bits = [] {
      unsigned count = 32;
      while (last < (std::uint64_t{1} << count) - 1) count /= 2;
      return count;
    }();
    constexpr std::uint64_t size = (last + 1) >> bits;
    std::uint32_t word = 0;
    for (unsigned have = 0; have < 32; have += bits) {
      std::uint64_t part = next() / size;
      while ((part >> bits) != 0) part = next() / size;
      word = bits == 32 ? static_cast<std::uint32_t>(part) : (word << (bits % 32)) | static_cast<std::uint32_t>(part);
    }
    return word;
  }
}

/// One number uniform on [0, 1), never 1, on the grid of 2^-24 (float) or 2^-53 (double, long double).
template <std::floating_point T, UniformSource S>
[[nodiscard]] constexpr T uniform(S& source) {
  if constexpr (std::same_as<T, float>) {
    if constexpr (has_64_bit_words<S>)
      return static_cast<float>(static_cast<std::uint64_t>(source()) >> 40) * 0x1p-24F;
    else
      return static_cast<float>(uniform_word(source) >> 8) * 0x1p-24F;
  } else {
    if constexpr (has_64_bit_words<S>) {
      return static_cast<T>(static_cast<std::uint64_t>(source()) >> 11) * T(0x1p-53);
    } else {
      const std::uint64_t high = uniform_word(source) >> 5;
      const std::uint64_t low = uniform_word(source) >> 6;
      return static_cast<T>((high << 26U) | low) * T(0x1p-53);
    }
  }
}

/// An integer uniform on {0, …, count − 1}; `count` ≥ 1. The bias of the multiplication is below count / 2^64
/// for 64-bit words made here, so at most 2^-32 for any count that fits 32 bits.
template <UniformSource S>
[[nodiscard]] constexpr std::uint32_t uniform_index(S& source, std::uint32_t count) {
  std::uint64_t word = 0;
  if constexpr (has_64_bit_words<S>) {
    word = static_cast<std::uint64_t>(source());
  } else {
    word = static_cast<std::uint64_t>(uniform_word(source)) << 32U;
    word |= uniform_word(source);
  }
  // floor(word · count / 2^64) from two 32-bit halves, without a 128-bit type.
  const std::uint64_t high = (word >> 32U) * count;
  const std::uint64_t low = (word & 0xFFFFFFFFU) * count;
  return static_cast<std::uint32_t>((high + (low >> 32U)) >> 32U);
}

/// Four random 32-bit words from a 128-bit counter and a 64-bit key: Philox4x32-10
/// (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3. SC 2011).
[[nodiscard]] constexpr std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                                                std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = std::uint64_t{0xD2511F53U} * counter[0];
    const std::uint64_t product1 = std::uint64_t{0xCD9E8D57U} * counter[2];
    counter = {static_cast<std::uint32_t>(product1 >> 32U) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(product1),
               static_cast<std::uint32_t>(product0 >> 32U) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(product0)};
    key[0] += 0x9E3779B9U;
    key[1] += 0xBB67AE85U;
  }
  return counter;
}

/// The default uniform source: counter-based, so that a number is a pure function of where it is used and not of what
/// was drawn before. It is keyed by (seed, iteration, path) and laid out by vertex: `at_vertex(v)` starts the numbers
/// of vertex `v`, whatever its siblings used. A `std::uniform_random_bit_generator` of 32-bit words.
///
/// Outside a renderer (seed, iteration, path) number streams: sources that differ in any of the three draw from disjoint
/// parts of one sequence, 2^34 words each (then they repeat), so `Philox(seed, 0, i)` is the source of the i-th of several threads or blocks.
class Philox {
 public:
  using result_type = std::uint32_t;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  constexpr explicit Philox(std::uint64_t seed = 0, std::uint32_t iteration = 0, std::uint32_t path = 0,
                            std::uint32_t stream = 0) noexcept
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U)},
        counter_{0, stream << 24U, path, iteration} {}

  /// Moves to the first number of vertex `vertex` (below 2^24) of this path.
  constexpr void at_vertex(std::uint32_t vertex) noexcept {
    counter_[0] = 0;
    counter_[1] = (counter_[1] & 0xFF000000U) | (vertex & 0x00FFFFFFU);
    used_ = 4;
  }

  constexpr result_type operator()() noexcept {
    if (used_ == 4) {
      block_ = philox4x32(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return block_[used_++];
  }

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;  // block within the vertex, stream and vertex, path, iteration
  std::array<std::uint32_t, 4> block_{};
  std::uint32_t used_ = 4;
};

}  // namespace gmis
