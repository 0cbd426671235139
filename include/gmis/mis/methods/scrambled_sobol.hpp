#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace gmis {

/// Points of Sobol' in nested uniform scrambling [Owen 1995] as a uniform source: each call gives
/// the next coordinate of the point at hand. Every point is uniform by itself, and the first 2^m
/// points of a stream are spread evenly, so that means of smooth functions have variances of the
/// order n^-3 in place of n^-1. Randomisations (rounds) and streams are independent.
///
/// A sampler must use its numbers in the same order for every sample (inversion: one a dimension),
/// else the points are merely random. The first ten dimensions are Sobol's [direction numbers: Joe,
/// Kuo 2008], further ones independent random numbers. 32 bits are scrambled; the others are
/// random.
class ScrambledSobol {
 public:
  using result_type = std::uint64_t;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }
  /// Most numbers of one point.
  static constexpr std::size_t dimensions = 10;

  /// The scramble that this seed selects.
  constexpr explicit ScrambledSobol(std::uint64_t seed) noexcept : seed_(mix(seed)) {}

  /// Begins randomisation `round`.
  constexpr void start_round(std::uint64_t round) noexcept { round_ = mix(seed_ ^ mix(round + 1)); }
  /// Moves to the first coordinate of point `index` of `stream`.
  constexpr void start_sample(std::uint64_t stream, std::uint32_t index) noexcept {
    key_ = mix(round_ ^ mix(stream + 0x5851F42D4C957F2DU));
    index_ = index;
    dimension_ = 0;
  }

  constexpr result_type operator()() noexcept {
    const std::uint64_t key = mix(key_ ^ mix(dimension_ + 1));
    const std::uint64_t noise = mix(key ^ mix(index_ + 0x14057B7EF767814FU));
    if (dimension_ >= dimensions) {
      ++dimension_;
      return noise;
    }
    const std::uint32_t point = coordinate(dimension_++, index_);
    std::uint32_t flips = 0;
    for (unsigned bit = 0; bit < 32; ++bit) {
      // One flip for each node of the binary tree: its bits above, and a one before them, are its
      // number.
      const std::uint64_t node = (std::uint64_t{1} << bit) | (std::uint64_t{point} >> (32 - bit));
      flips |= static_cast<std::uint32_t>(mix(key ^ (node * 0x9E3779B97F4A7C15U)) >> 63U) << (31 - bit);
    }
    return (std::uint64_t{point ^ flips} << 32U) | (noise >> 32U);
  }

  /// Coordinate `dimension` of point `index` before scrambling, times 2^32.
  [[nodiscard]] static constexpr std::uint32_t coordinate(std::size_t dimension, std::uint32_t index) noexcept {
    std::uint32_t result = 0;
    for (unsigned bit = 0; index != 0; ++bit, index >>= 1U)
      if ((index & 1U) != 0) result ^= directions[dimension][bit];
    return result;
  }

 private:
  // The finaliser of SplitMix64: every bit of the result depends on every bit of the argument.
  [[nodiscard]] static constexpr std::uint64_t mix(std::uint64_t z) noexcept {
    z += 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  struct Primitive {
    unsigned degree, coefficients;
    std::array<std::uint32_t, 5> first;
  };
  using Directions = std::array<std::array<std::uint32_t, 32>, dimensions>;
  [[nodiscard]] static constexpr Directions make_directions() noexcept {
    constexpr std::array<Primitive, dimensions - 1> table{{{1, 0, {1}},
                                                           {2, 1, {1, 3}},
                                                           {3, 1, {1, 3, 1}},
                                                           {3, 2, {1, 1, 1}},
                                                           {4, 1, {1, 1, 3, 3}},
                                                           {4, 4, {1, 3, 5, 13}},
                                                           {5, 2, {1, 1, 5, 5, 17}},
                                                           {5, 4, {1, 1, 5, 5, 5}},
                                                           {5, 7, {1, 1, 7, 11, 19}}}};
    Directions result{};
    for (unsigned bit = 0; bit < 32; ++bit) result[0][bit] = std::uint32_t{1} << (31 - bit);
    for (std::size_t d = 1; d < dimensions; ++d) {
      const Primitive& p = table[d - 1];
      for (unsigned bit = 0; bit < 32; ++bit) {
        if (bit < p.degree) {
          result[d][bit] = p.first[bit] << (31 - bit);
          continue;
        }
        std::uint32_t v = result[d][bit - p.degree] ^ (result[d][bit - p.degree] >> p.degree);
        for (unsigned i = 1; i < p.degree; ++i)
          if (((p.coefficients >> (p.degree - 1 - i)) & 1U) != 0) v ^= result[d][bit - i];
        result[d][bit] = v;
      }
    }
    return result;
  }
  static const Directions directions;

  std::uint64_t seed_;
  std::uint64_t round_ = 0;
  std::uint64_t key_ = 0;
  std::uint32_t index_ = 0;
  std::size_t dimension_ = 0;
};

inline constexpr ScrambledSobol::Directions ScrambledSobol::directions = ScrambledSobol::make_directions();

}  // namespace gmis
