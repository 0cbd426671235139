#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "gmis/core/random.hpp"

/// \file
/// Low-discrepancy numbers for subpaths: Sobol' points in four dimensions, scrambled and shuffled anew for every four
/// numbers of every vertex [Burley 2020: Practical hash-based Owen scrambling].

namespace gmis {

/// How the numbers of a run are drawn.
enum class Sampler : std::uint8_t {
  independent,  ///< `Philox`: iterations are independent of each other
  sobol         ///< scrambled Sobol' points in `sobol_replications` independent replications
};

/// Iteration i belongs to replication (i − 1) mod this. Replications are independent of each other; the iterations of one
/// replication are not.
inline constexpr std::uint32_t sobol_replications = 8;

namespace detail {

/// Four numbers worked on at once, where the compiler has such a type.
#if defined(__GNUC__)
using FourWords __attribute__((vector_size(16))) = std::uint32_t;
#endif

/// Of a `std::uint32_t`, or of four.
template <class Word>
[[nodiscard]] constexpr Word reverse_bits(Word x) noexcept {
  x = ((x >> 1U) & 0x55555555U) | ((x & 0x55555555U) << 1U);
  x = ((x >> 2U) & 0x33333333U) | ((x & 0x33333333U) << 2U);
  x = ((x >> 4U) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4U);
  x = ((x >> 8U) & 0x00FF00FFU) | ((x & 0x00FF00FFU) << 8U);
  return (x >> 16U) | (x << 16U);
}

/// A permutation in which each bit of the result depends on the bits below it and the seed alone [Laine, Karras 2011;
/// the constants of Burley 2020]. On a number with its bits reversed, it is a nested uniform scrambling.
template <class Word>
[[nodiscard]] constexpr Word laine_karras(Word x, Word seed) noexcept {
  x += seed;
  x ^= x * 0x6C50B47CU;
  x ^= x * 0xB82F1E52U;
  x ^= x * 0xC7AFE638U;
  x ^= x * 0x8D22F6E6U;
  return x;
}

/// The first four dimensions of Sobol' [direction numbers: Joe, Kuo 2008], with reversed bits: entry j is the one that bit
/// 31 − j of a point's number adds.
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

/// What four bits of a point's number add, for every value of them: entry [n][value] is for the bits from 4 n on.
inline constexpr auto sobol_sums = [] {
  std::array<std::array<std::array<std::uint32_t, 4>, 16>, 8> sums{};
  for (std::size_t n = 0; n < 8; ++n)
    for (std::size_t value = 0; value < 16; ++value)
      for (std::size_t bit = 0; bit < 4; ++bit)
        if ((value >> bit & 1U) != 0)
          for (std::size_t d = 0; d < 4; ++d) sums[n][value][d] ^= sobol_directions[4 * n + bit][d];
  return sums;
}();

}  // namespace detail

/// The uniform source of the engine, by default that of `Philox` bit by bit, or with `sobol` a low-discrepancy one: the
/// numbers of many subpaths at one place of one vertex are then spread evenly over [0, 1), four by four together. A
/// single subpath has uniform numbers either way.
class SampleNumbers {
 public:
  using result_type = std::uint32_t;
  using Block = Philox::Block;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  /// The numbers of `Philox` with these arguments.
  constexpr explicit SampleNumbers(std::uint64_t seed = 0, std::uint32_t iteration = 0, std::uint32_t path = 0,
                                   std::uint32_t stream = 0) noexcept
      : blocks_(seed, iteration, path, stream) {}

  /// Point `index` of a sequence. The first 2^m points with the same other arguments, for any m ≤ `index_bits`, are
  /// spread evenly; after 2^`index_bits` points another sequence begins.
  [[nodiscard]] static constexpr SampleNumbers sobol(std::uint64_t seed, std::uint32_t replication, std::uint32_t path,
                                                     std::uint32_t stream, std::uint64_t index,
                                                     unsigned index_bits) noexcept {
    const auto round = static_cast<std::uint32_t>(index >> index_bits);
    SampleNumbers result(seed, replication + sobol_replications * round, path, stream);
    result.index_mask_ = ~std::uint32_t{0} << (32U - index_bits);
    result.reversed_index_ = detail::reverse_bits(static_cast<std::uint32_t>(index)) & result.index_mask_;
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
    const Block words = blocks_.next();
    if (index_mask_ != 0) [[unlikely]]
      return point(words, reversed_index_, index_mask_);
    return words;
  }

 private:
  /// The point's coordinates, scrambled by the words. The words also shuffle the numbers of the points: so, places with
  /// other words are independent of each other.
  [[nodiscard]] [[gnu::noinline]] static Block point(const Block& words, std::uint32_t reversed_index,
                                                     std::uint32_t index_mask) noexcept {
    // All four words enter the shuffle.
    std::uint32_t shuffle = (words[0] ^ std::rotl(words[1], 9)) * 0x9E3779B1U + (words[2] ^ std::rotl(words[3], 19));
    shuffle ^= shuffle >> 15U;
    const std::uint32_t bits = detail::laine_karras(reversed_index, shuffle) & index_mask;
    // Four bits at a time: as many steps for every point of a sequence, so that a processor foresees the end of the loop.
    const auto first = static_cast<std::size_t>(std::countr_zero(index_mask)) / 4;
    Block coordinates{};
#if defined(__GNUC__)
    detail::FourWords all{}, seeds{words[0], words[1], words[2], words[3]};
    for (std::size_t n = first; n < 8; ++n) {
      const auto& sum = detail::sobol_sums[n][bits >> 4 * n & 15U];
      all ^= detail::FourWords{sum[0], sum[1], sum[2], sum[3]};
    }
    all = detail::reverse_bits(detail::laine_karras(all, seeds));
    for (std::size_t d = 0; d < 4; ++d) coordinates[d] = all[d];
#else
    for (std::size_t n = first; n < 8; ++n)
      for (std::size_t d = 0; d < 4; ++d) coordinates[d] ^= detail::sobol_sums[n][bits >> 4 * n & 15U][d];
    for (std::size_t d = 0; d < 4; ++d)
      coordinates[d] = detail::reverse_bits(detail::laine_karras(coordinates[d], words[d]));
#endif
    return coordinates;
  }

  PhiloxBlocks blocks_;
  std::uint32_t reversed_index_ = 0;
  std::uint32_t index_mask_ = 0;  ///< 0: no Sobol' points
  Block block_{};
  std::uint32_t used_ = 4;
};

}  // namespace gmis
