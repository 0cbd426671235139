#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "gmis/core/attributes.hpp"
#include "gmis/core/wyrand.hpp"

#if defined(__SSSE3__)
#include <tmmintrin.h>
#endif

/// \file
/// Low-discrepancy numbers for subpaths: Sobol' points in four dimensions, scrambled and shuffled
/// anew for every four numbers of every vertex [Burley 2020: Practical hash-based Owen scrambling].

namespace gmis {

/// How the numbers of a run are drawn.
enum class Sampler : std::uint8_t {
  independent,  ///< `WyrandBlocks`: iterations are independent of each other
  sobol         ///< scrambled Sobol' points in `sobol_replications` independent replications
};

/// Iteration i belongs to replication (i − 1) mod this. Replications are independent of each other;
/// the iterations of one replication are not.
inline constexpr std::uint32_t sobol_replications = 8;

namespace detail {

/// Four numbers worked on at once, where the compiler has such a type.
#if defined(__GNUC__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define GMIS_FOUR_WORDS
using FourWords GMIS_VECTOR_OF_BYTES(16) = std::uint32_t;
using TwoWords GMIS_VECTOR_OF_BYTES(16) = std::uint64_t;
#else
using FourWords = std::array<std::uint32_t, 4>;
#endif

/// The bits of a `std::uint32_t`, or of each of four, in reverse order.
template <class Word>
[[nodiscard]] constexpr Word reverse_bits(Word x) noexcept {
  x = ((x >> 1U) & 0x55555555U) | ((x & 0x55555555U) << 1U);
  x = ((x >> 2U) & 0x33333333U) | ((x & 0x33333333U) << 2U);
  x = ((x >> 4U) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4U);
  x = ((x >> 8U) & 0x00FF00FFU) | ((x & 0x00FF00FFU) << 8U);
  return (x >> 16U) | (x << 16U);
}

#if defined(__SSSE3__) && defined(GMIS_FOUR_WORDS)
/// The same by two look-ups a byte, which a processor makes for all bytes at once.
template <>
[[nodiscard]] inline FourWords reverse_bits(FourWords x) noexcept {
  const auto low = _mm_set1_epi8(0x0F);
  const auto reversed_high =
      _mm_setr_epi8(0x0, 0x8, 0x4, 0xC, 0x2, 0xA, 0x6, 0xE, 0x1, 0x9, 0x5, 0xD, 0x3, 0xB, 0x7, 0xF);
  const auto reversed_low = _mm_slli_epi16(reversed_high, 4);
  const auto bytes = _mm_shuffle_epi8(reinterpret_cast<__m128i>(x),
                                      _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const auto of_low = _mm_shuffle_epi8(reversed_low, _mm_and_si128(bytes, low));
  const auto of_high = _mm_shuffle_epi8(reversed_high, _mm_and_si128(_mm_srli_epi16(bytes, 4), low));
  return reinterpret_cast<FourWords>(_mm_or_si128(of_low, of_high));
}
#endif

/// A permutation in which each bit of the result depends on itself, on the bits below it and on the
/// seeds alone: on a number with its bits reversed, a nested scrambling [as Laine, Karras 2011,
/// whose factors are constants]. Uniform when `shift` is, whatever the factors are. With random
/// factors two products are as good as a nested uniform scrambling [Owen 1995]: the variances of
/// means are the same, where those of four constant factors differ in either direction.
template <class Word>
[[nodiscard]] constexpr Word scramble(Word x, Word shift, Word first, Word second) noexcept {
  x += shift;
  x ^= x * (first + first);
  x ^= x * (second + second);
  return x;
}

/// The first four dimensions of Sobol' [direction numbers: Joe, Kuo 2008], with reversed bits:
/// entry j is the one that bit 31 − j of a point's number adds.
[[nodiscard]] constexpr std::array<std::array<std::uint32_t, 4>, 32> reversed_directions() noexcept {
  struct Primitive {
    unsigned degree, coefficients;
    std::array<std::uint32_t, 3> first;
  };
  constexpr std::array<Primitive, 3> table{{{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}}};
  std::array<std::array<std::uint32_t, 4>, 32> result{};
  for (unsigned bit = 0; bit < 32; ++bit) result[31 - bit][0] = std::uint32_t{1} << bit;
  for (std::size_t d = 1; d < 4; ++d) {
    const Primitive& p = table[d - 1];
    std::array<std::uint32_t, 32> v{};
    for (unsigned bit = 0; bit < 32; ++bit) {
      if (bit < p.degree) {
        v[bit] = p.first[bit] << (31 - bit);
      } else {
        v[bit] = v[bit - p.degree] ^ (v[bit - p.degree] >> p.degree);
        for (unsigned i = 1; i < p.degree; ++i)
          if (((p.coefficients >> (p.degree - 1 - i)) & 1U) != 0) v[bit] ^= v[bit - i];
      }
      result[31 - bit][d] = reverse_bits(v[bit]);
    }
  }
  return result;
}
inline constexpr auto sobol_directions = reversed_directions();

/// The sums that four bits of a point's number add, for every value of the four: entry [n][value]
/// is for the bits from 4 n on.
struct alignas(16) SobolSums {
  std::array<std::array<std::array<std::uint32_t, 4>, 16>, 8> of{};
};
inline constexpr SobolSums sobol_sums = [] {
  SobolSums sums;
  for (std::size_t n = 0; n < 8; ++n)
    for (std::size_t value = 0; value < 16; ++value)
      for (std::size_t bit = 0; bit < 4; ++bit)
        if ((value >> bit & 1U) != 0)
          for (std::size_t d = 0; d < 4; ++d) sums.of[n][value][d] ^= sobol_directions[4 * n + bit][d];
  return sums;
}();

/// Shuffles the number of a point, with reversed bits: `scramble` without a shift, so that the
/// lowest bit that is set stays where it is, and for every m the first 2^m points stay the first.
/// The shift of a nested uniform shuffle would make no difference to points that are scrambled
/// afterwards.
[[nodiscard]] constexpr std::uint32_t shuffle(std::uint32_t reversed_index, std::uint64_t seed) noexcept {
  return scramble(reversed_index, 0U, static_cast<std::uint32_t>(seed >> 32U), static_cast<std::uint32_t>(seed >> 16U));
}

}  // namespace detail

/// The uniform source of the engine: the words of `WyrandBlocks`, or with `sobol` low-discrepancy
/// numbers: those of many subpaths at one place of one vertex are spread evenly over [0, 1), four
/// by four together. A single subpath has uniform numbers either way.
class SampleNumbers {
 public:
  using result_type = std::uint32_t;
  using Block = WyrandBlocks::Block;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  /// Independent numbers: the words of `WyrandBlocks` with these arguments.
  constexpr explicit SampleNumbers(std::uint64_t seed = 0, std::uint32_t iteration = 0, std::uint32_t path = 0,
                                   std::uint32_t stream = 0) noexcept
      : blocks_(seed, iteration, path, stream) {}

  /// Point `index` of a sequence. The first 2^m points with the same other arguments, for any m ≤
  /// `index_bits`, are spread evenly; after 2^`index_bits` points another sequence begins.
  [[nodiscard]] static constexpr SampleNumbers sobol(std::uint64_t seed, std::uint32_t replication, std::uint32_t path,
                                                     std::uint32_t stream, std::uint64_t index,
                                                     unsigned index_bits) noexcept {
    const auto round = static_cast<std::uint32_t>(index >> index_bits);
    SampleNumbers result(seed, replication + sobol_replications * round, path, stream);
    result.is_sobol_ = true;
    result.reversed_index_ =
        detail::reverse_bits(static_cast<std::uint32_t>(index) & ((std::uint32_t{1} << index_bits) - 1));
    return result;
  }

  /// Moves to the first number of vertex `vertex` (below 2^24) of this subpath.
  constexpr void at_vertex(std::uint32_t vertex) noexcept {
    blocks_.at_vertex(vertex);
    used_ = 4;
  }

  result_type operator()() noexcept {
    if (used_ == 4) {
      block_ = next_block();
      used_ = 0;
    }
    return block_[used_++];
  }

  /// The next four numbers that no call has begun to use.
  Block next_block() noexcept {
    used_ = 4;
    if (is_sobol_) return point(blocks_.next_words(), reversed_index_);
    return blocks_.next_block();
  }

 private:
  /// The coordinates of a point, scrambled by the words of a block. The words also shuffle the
  /// numbers of the points: so, places with other words are independent of each other.
  [[nodiscard]] GMIS_NEVER_INLINE static Block point(std::array<std::uint64_t, 2> words,
                                                     std::uint32_t reversed_index) noexcept {
    // Four bits at a time, from the highest. Nearly all points of an iteration take equally many
    // steps.
    std::uint32_t bits = detail::shuffle(reversed_index, (words[0] ^ std::rotl(words[1], 21)) * 0x9E3779B97F4A7C15U);
    detail::FourWords sum{};
    for (std::size_t n = 7; bits != 0; --n, bits <<= 4U) {
      const auto& added = detail::sobol_sums.of[n][bits >> 28U];
      for (std::size_t d = 0; d < 4; ++d) sum[d] ^= added[d];
    }
    // Each coordinate has a shift of its own, and the shifts of two others are its factors: bit k
    // of a factor is made of lower bits than k, so the four together are uniform for every `sum`.
    Block coordinates{};
#if defined(GMIS_FOUR_WORDS)
    const auto four = [](std::uint64_t low, std::uint64_t high) {
      return std::bit_cast<detail::FourWords>(detail::TwoWords{low, high});
    };
    sum = detail::reverse_bits(detail::scramble(sum, four(words[0], words[1]), four(words[1], words[0]),
                                                four(std::rotl(words[0], 32), std::rotl(words[1], 32))));
    for (std::size_t d = 0; d < 4; ++d) coordinates[d] = sum[d];
#else
    const auto seed = [&words](std::size_t d) { return static_cast<std::uint32_t>(words[d / 2] >> (32U * (d % 2))); };
    for (std::size_t d = 0; d < 4; ++d)
      coordinates[d] = detail::reverse_bits(detail::scramble(sum[d], seed(d), seed(d ^ 2U), seed(d ^ 1U)));
#endif
    return coordinates;
  }

  WyrandBlocks blocks_;
  std::uint32_t reversed_index_ = 0;
  bool is_sobol_ = false;
  Block block_{};
  std::uint32_t used_ = 4;
};

}  // namespace gmis
