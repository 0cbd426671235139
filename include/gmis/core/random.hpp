#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace gmis {

/// The source that the library draws random numbers from: any `std::uniform_random_bit_generator`,
/// so every engine of `<random>` (also `std::default_random_engine`, `std::minstd_rand`,
/// `std::ranlux48`, `std::random_device`), the `Philox` below, or your own class. A source whose
/// words have 32 or 64 full bits (`Philox`, `std::mt19937`, `std::mt19937_64`) is used as it is;
/// the bits of any other are put together, and the words that would make them uneven are drawn
/// again.
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
    // Each word gives 32, 16, 8, 4, 2 or 1 bits: the most of these that it has. They number equal
    // parts of its range.
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

/// One number uniform on [0, 1), never 1, on the grid of 2^-24 (float) or 2^-53 (double, long
/// double).
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

/// An integer uniform on {0, …, count − 1}; `count` ≥ 1. The bias of the multiplication is below
/// count / 2^64 for 64-bit words made here, so at most 2^-32 for any count that fits 32 bits.
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

namespace detail {

/// The high and the low half of a 128-bit product.
struct Product128 {
  std::uint64_t high, low;
};
[[nodiscard]] constexpr Product128 multiply(std::uint64_t a, std::uint64_t b) noexcept {
#if defined(__SIZEOF_INT128__)
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(a) * b;
  return {static_cast<std::uint64_t>(product >> 64U), static_cast<std::uint64_t>(product)};
#else
  constexpr std::uint64_t half = 0xFFFFFFFFU;
  const std::uint64_t low = (a & half) * (b & half);
  const std::uint64_t middle = (a >> 32U) * (b & half) + (low >> 32U);
  const std::uint64_t other = (a & half) * (b >> 32U) + (middle & half);
  return {(a >> 32U) * (b >> 32U) + (middle >> 32U) + (other >> 32U), a * b};
#endif
}

/// Two words of 64 bits as four of 32, each high half first.
[[nodiscard]] constexpr std::array<std::uint32_t, 4> halves_of(const std::array<std::uint64_t, 2>& words) noexcept {
  return {static_cast<std::uint32_t>(words[0] >> 32U), static_cast<std::uint32_t>(words[0]),
          static_cast<std::uint32_t>(words[1] >> 32U), static_cast<std::uint32_t>(words[1])};
}

}  // namespace detail

/// Two random 64-bit words from a 128-bit counter and a 64-bit key: Philox2x64 with a number of
/// rounds (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as 1, 2, 3. SC 2011). Its
/// authors found no failure of BigCrush from 6 rounds on.
template <int rounds>
[[nodiscard]] constexpr std::array<std::uint64_t, 2> philox2x64(std::array<std::uint64_t, 2> counter,
                                                                std::uint64_t key) noexcept {
  for (int round = 0; round < rounds; ++round) {
    const detail::Product128 product = detail::multiply(0xD2B74407B1CE6E93U, counter[0]);
    counter = {product.high ^ key ^ counter[1], product.low};
    key += 0x9E3779B97F4A7C15U;
  }
  return counter;
}

/// A counter-based uniform source: a number is a pure function of the place where it is used, and
/// does not depend on earlier draws. It is keyed by (seed, iteration, path, stream) and laid out by
/// vertex: `at_vertex(v)` starts the numbers of vertex `v`, whatever its siblings used. A
/// `std::uniform_random_bit_generator` of 32-bit words, made in blocks of four by `philox2x64<7>`:
/// one round more than the tests of its authors ask for.
///
/// Outside a renderer, (iteration, path) number the streams of a seed: disjoint parts of its
/// sequence, 2^34 words each (then they repeat). `Philox(seed, 0, i)` is the source of the i-th of
/// several threads or blocks.
class Philox {
 public:
  using result_type = std::uint32_t;
  using Block = std::array<std::uint32_t, 4>;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  /// The numbers of one path: the same arguments give the same numbers, and others independent
  /// ones. `stream` counts modulo 256.
  constexpr explicit Philox(std::uint64_t seed = 0, std::uint32_t iteration = 0, std::uint32_t path = 0,
                            std::uint32_t stream = 0) noexcept
      : key_(seed), path_(std::uint64_t{iteration} << 32U | path), place_(std::uint64_t{stream} << 56U) {}

  /// Moves to the first number of vertex `vertex` (below 2^24) of this path.
  constexpr void at_vertex(std::uint32_t vertex) noexcept {
    place_ = (place_ & 0xFF00000000000000U) | std::uint64_t{vertex & 0x00FFFFFFU} << 32U;
    used_ = 4;
  }

  constexpr result_type operator()() noexcept {
    if (used_ == 4) {
      block_ = next_block();
      used_ = 0;
    }
    return block_[used_++];
  }

  /// The next four words that no call has begun to use: words of a block that is partly used are
  /// passed over.
  constexpr Block next_block() noexcept {
    used_ = 4;
    const std::array<std::uint64_t, 2> words = philox2x64<7>({place_, path_}, key_);
    // The number of the block is the low half of the counter; it wraps without touching the vertex.
    place_ = (place_ & 0xFFFFFFFF00000000U) | static_cast<std::uint32_t>(place_ + 1);
    return detail::halves_of(words);
  }

 private:
  std::uint64_t key_;
  std::uint64_t path_;   // iteration, path
  std::uint64_t place_;  // stream, vertex, block within the vertex
  Block block_{};
  std::uint32_t used_ = 4;
};

/// `n` ≤ 4 numbers, each as by `uniform<T>`. From a source that makes words in blocks
/// (`next_block`), floats are the first `n` of a fresh block: this costs neither a place in memory
/// nor a test a number.
template <std::floating_point T, std::size_t n, UniformSource S>
[[nodiscard]] constexpr std::array<T, n> uniforms(S& source) {
  static_assert(n <= 4);
  std::array<T, n> result{};
  if constexpr (std::same_as<T, float> && requires { source.next_block(); }) {
    const auto block = source.next_block();
    for (std::size_t i = 0; i < n; ++i) result[i] = static_cast<float>(block[i] >> 8U) * 0x1p-24F;
  } else {
    for (T& number : result) number = uniform<T>(source);
  }
  return result;
}

}  // namespace gmis
