#pragma once

#include <array>
#include <cstdint>

#include "gmis/core/random.hpp"

namespace gmis {

/// Blocks of four random 32-bit words, keyed by (seed, iteration, path, stream) and laid out by
/// vertex: the same arguments give the same blocks, whatever was drawn before. For less than half
/// of the instructions of `Philox`: a word of 64 bits is w(s) = high ⊕ low half of the product s ·
/// (s ⊕ c) at a place s of an arithmetic sequence (wyrand; Wang Yi, wyhash, 2019; its author
/// reports that it passes BigCrush and PractRand). All paths read this one function, from places
/// that a hash of the key selects among 2^64.
class WyrandBlocks {
 public:
  using Block = std::array<std::uint32_t, 4>;

  /// The blocks of one path, from vertex 0 on. `stream` counts modulo 256.
  constexpr WyrandBlocks(std::uint64_t seed, std::uint32_t iteration, std::uint32_t path, std::uint32_t stream) noexcept
      : first_(first_place(seed, std::uint64_t{iteration} << 32U | path, stream)), place_(first_) {}

  /// Moves to the first block of vertex `vertex` (below 2^24).
  constexpr void at_vertex(std::uint32_t vertex) noexcept { place_ = first_ + vertex * vertex_step; }

  /// The next block as two words of 64 bits.
  constexpr std::array<std::uint64_t, 2> next_words() noexcept {
    const std::array<std::uint64_t, 2> words{folded(place_, place_ ^ flips),
                                             folded(place_ + step, (place_ + step) ^ flips)};
    place_ += 2 * step;
    return words;
  }
  /// The next four words.
  constexpr Block next_block() noexcept { return detail::halves_of(next_words()); }

  static constexpr std::uint64_t step = 0xA0761D6478BD642FU;         ///< from word to word
  static constexpr std::uint64_t vertex_step = 0xD1B54A32D192ED03U;  ///< from vertex to vertex
  static constexpr std::uint64_t flips = 0xE7037ED1A0B428DBU;        ///< c

 private:
  [[nodiscard]] static constexpr std::uint64_t folded(std::uint64_t a, std::uint64_t b) noexcept {
    const detail::Product128 product = detail::multiply(a, b);
    return product.high ^ product.low;
  }
  /// For any seed the low half of the first product differs from path to path.
  [[nodiscard]] static constexpr std::uint64_t first_place(std::uint64_t seed, std::uint64_t path,
                                                           std::uint64_t stream) noexcept {
    const detail::Product128 product = detail::multiply(path ^ flips, step);
    return folded(product.low ^ seed, product.high ^ flips ^ stream << 56U);
  }

  std::uint64_t first_;  // place of vertex 0
  std::uint64_t place_;
};

}  // namespace gmis
