#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace gmis_test {

/// The fractional parts of the roots of the first primes, times 2^64, bit by bit.
template <std::size_t root_count>
[[nodiscard]] constexpr std::array<std::uint64_t, root_count> square_roots() {
  std::array<std::uint64_t, root_count> result{};
  std::size_t found = 0;
  for (std::uint64_t n = 2; found < root_count; ++n) {
    bool is_prime = true;
    for (std::uint64_t d = 2; d * d <= n; ++d) is_prime = is_prime && n % d != 0;
    if (!is_prime) continue;
    // Two bits of n, then two zeros at a time: the school's method for √(n · 2^2b). The remainder
    // stays below 2^54.
    std::uint64_t root = 0, rest = 0;
    for (int bit = 62; bit >= -48; bit -= 2) {
      rest = (rest << 2U) | (bit >= 0 ? (n >> static_cast<unsigned>(bit)) & 3U : 0U);
      const std::uint64_t trial = (root << 2U) | 1U;
      root <<= 1U;
      if (rest >= trial) {
        rest -= trial;
        root |= 1U;
      }
    }
    result[found++] = root << 40U;  // 24 binary places
  }
  return result;
}

/// Random numbers for the engine that lie evenly from path to path: number j of path i is i √p_j +
/// a shift, all modulo 1, p_j the primes [Richtmyer 1951; Cranley, Patterson 1976]. The shifts are
/// independent random numbers, new in every iteration: each path by itself has independent uniform
/// numbers, so the mean of an iteration is as unbiased as with any others and iterations are
/// independent, but it has far less noise. A vertex may use 16 numbers.
class ShiftedLattice {
 public:
  using result_type = std::uint32_t;
  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  constexpr explicit ShiftedLattice(std::uint64_t seed = 0, std::uint32_t iteration = 0, std::uint32_t path = 0,
                                    std::uint32_t stream = 0) noexcept
      : key_(mixed(mixed(seed + 1) ^ ((std::uint64_t{iteration} << 8U) | stream))), path_(path) {}

  constexpr void at_vertex(std::uint32_t vertex) noexcept { next_ = std::uint64_t{vertex} * numbers_per_vertex; }

  constexpr result_type operator()() noexcept {
    const std::uint64_t j = next_++;
    const std::uint64_t shift = mixed(key_ + j * 0x9E3779B97F4A7C15U);
    // Far along a path, where there are no more roots, numbers are plainly random.
    if (j >= roots.size()) return static_cast<result_type>(mixed(shift + path_) >> 32U);
    return static_cast<result_type>((std::uint64_t{path_} * roots[static_cast<std::size_t>(j)] + shift) >> 32U);
  }

 private:
  static constexpr std::uint64_t numbers_per_vertex = 16;
  static constexpr std::size_t root_count = 128;

  /// A bijection that leaves no trace of its argument (the finaliser of SplitMix64).
  [[nodiscard]] static constexpr std::uint64_t mixed(std::uint64_t x) noexcept {
    x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9U;
    x = (x ^ (x >> 27U)) * 0x94D049BB133111EBU;
    return x ^ (x >> 31U);
  }

  static constexpr std::array<std::uint64_t, root_count> roots = square_roots<root_count>();

  std::uint64_t key_;
  std::uint64_t path_;
  std::uint64_t next_ = 0;
};

}  // namespace gmis_test
