#include "gmis/core/sobol_numbers.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "gmis/core/statistics.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using gmis::SampleNumbers;

namespace {

constexpr unsigned index_bits = 16;

/// The block that point `index` has at place `block` of `vertex`.
SampleNumbers::Block block_of(std::uint64_t seed, std::uint32_t replication, std::uint32_t path, std::uint64_t index,
                              std::uint32_t vertex, int block = 0) {
  auto source = SampleNumbers::sobol(seed, replication, path, 1, index, index_bits);
  source.at_vertex(vertex);
  for (int i = 0; i < block; ++i) static_cast<void>(source.next_block());
  return source.next_block();
}

double unit(std::uint32_t word) {
  return static_cast<double>(word) * 0x1p-32;
}

}  // namespace

TEST_CASE(
    "without Sobol' points the numbers are those of the blocks, and a block is the next four that nobody has begun to "
    "use") {
  gmis::WyrandBlocks blocks(gmis_test::seed(1), 2, 3, 1);
  SampleNumbers numbers(gmis_test::seed(1), 2, 3, 1);
  for (const std::uint32_t vertex : {0U, 5U, 1U}) {
    blocks.at_vertex(vertex);
    numbers.at_vertex(vertex);
    for (const std::uint32_t word : blocks.next_block()) CHECK(word == numbers());
    CHECK(blocks.next_block()[0] == numbers());
    CHECK(blocks.next_block() == numbers.next_block());
    CHECK(blocks.next_block()[0] == numbers());
  }
}

TEST_CASE("a scrambled bit depends on the bits above it alone, and half of the seeds flip it") {
  gmis::Philox source(gmis_test::seed(2));
  int flipped = 0;
  for (int n = 0; n < 4096; ++n) {
    const std::uint32_t x = source(), bit = source() % 32U;
    const std::array<std::uint32_t, 3> seeds{source(), source(), source()};
    const auto scrambled = [&](std::uint32_t word) {
      return gmis::detail::scramble(word, seeds[0], seeds[1], seeds[2]);
    };
    const std::uint32_t below = x ^ (std::uint32_t{1} << bit);  // as numbers with reversed bits
    CHECK(std::countr_zero(scrambled(x) ^ scrambled(below)) == static_cast<int>(bit));
    flipped += static_cast<int>(((scrambled(x) ^ x) >> bit) & 1U);
  }
  CHECK(std::abs(flipped - 2048) < 32 * gmis::normal_quantile(1.0 - 0.5e-6));
  CHECK(gmis::detail::reverse_bits(0x80000001U) == 0x80000001U);
  CHECK(gmis::detail::reverse_bits(0x12345678U) == 0x1E6A2C48U);
}

TEST_CASE("a shuffle keeps the first 2^m points the first, and moves them about otherwise") {
  gmis::Philox source(gmis_test::seed(6));
  using gmis::detail::reverse_bits;
  // Where the fifth to the eighth of eight points go: each to each of these places in a quarter of
  // the seeds.
  constexpr int count = 1 << 14;
  std::array<std::array<double, 4>, 4> places{};
  for (int n = 0; n < count; ++n) {
    const std::uint64_t seed = static_cast<std::uint64_t>(source()) << 32U | source();
    std::uint32_t met = 0;
    for (std::uint32_t i = 0; i < 32; ++i) {
      const std::uint32_t to = reverse_bits(gmis::detail::shuffle(reverse_bits(i), seed));
      REQUIRE(std::bit_width(to) == std::bit_width(i));
      met |= 1U << to;
      if (i >= 4 && i < 8) ++places[i - 4][to - 4];
    }
    REQUIRE(met == 0xFFFFFFFFU);
  }
  for (const auto& row : places) {
    double chi_squared = 0.0;
    for (const double n : row) chi_squared += (n - count / 4.0) * (n - count / 4.0) / (count / 4.0);
    CHECK(gmis::chi_square_p_value(chi_squared, 3) > gmis::sidak_level(1e-6, 4));
  }
}

TEST_CASE("the variance of means is that of a nested uniform scrambling") {
  // Of x and of sin 7x over 64 points of the first dimension, which are numbers with reversed bits;
  // Owen's scrambling flips each bit by a random function of the bits above it, here a hash of 64
  // bits.
  gmis::Philox source(gmis_test::seed(7));
  constexpr int runs = 4000, points = 64;
  const auto hashed = [](std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  };
  const auto nested = [&](std::uint32_t x, std::uint64_t seed) {
    std::uint32_t result = x;
    for (std::uint64_t bit = 0; bit < 32; ++bit) {
      const std::uint64_t below = x & ((std::uint64_t{1} << bit) - 1);
      if ((hashed(hashed(seed + bit) + below) & 1U) != 0) result ^= std::uint32_t{1} << bit;
    }
    return result;
  };
  std::array<std::array<double, 2>, 2> sums{}, squares{};  // by kind and integrand
  for (int run = 0; run < runs; ++run) {
    const std::array<std::uint32_t, 4> seeds{source(), source(), source(), source()};
    const std::uint64_t seed = static_cast<std::uint64_t>(seeds[3]) << 32U | seeds[0];
    std::array<std::array<double, 2>, 2> means{};
    for (std::uint32_t i = 0; i < points; ++i) {
      const std::array<double, 2> at{
          unit(gmis::detail::reverse_bits(gmis::detail::scramble(i, seeds[0], seeds[1], seeds[2]))),
          unit(gmis::detail::reverse_bits(nested(i, seed)))};
      for (std::size_t kind = 0; kind < 2; ++kind) {
        means[kind][0] += at[kind] / points;
        means[kind][1] += std::sin(7.0 * at[kind]) / points;
      }
    }
    for (std::size_t kind = 0; kind < 2; ++kind)
      for (std::size_t f = 0; f < 2; ++f)
        sums[kind][f] += means[kind][f], squares[kind][f] += means[kind][f] * means[kind][f];
  }
  for (std::size_t f = 0; f < 2; ++f) {
    const auto variance = [&](std::size_t kind) { return squares[kind][f] / runs - std::pow(sums[kind][f] / runs, 2); };
    // Each variance has a standard error of √(2 / runs) where means are normal: 64 strata make them
    // so.
    CHECK(std::log(variance(0) / variance(1)) == Approx(0.0).margin(6.0 * std::sqrt(4.0 / runs)));
  }
}

TEST_CASE(
    "the first 2^m points are a net: one in every elementary interval of the first two dimensions, each alone too") {
  for (std::uint32_t run = 0; run < 6; ++run)
    for (const unsigned m : {0U, 1U, 4U, 7U, 10U}) {
      const std::uint32_t count = 1U << m;
      std::vector<SampleNumbers::Block> points;
      for (std::uint32_t i = 0; i < count; ++i)
        points.push_back(block_of(gmis_test::seed(3), run, 7, i, 3 * run, static_cast<int>(run % 3)));
      CAPTURE(run, m);
      const auto is_net = [&](auto&& cell_of) {
        std::vector<int> cells(count, 0);
        for (const auto& point : points) ++cells[cell_of(point)];
        return std::all_of(cells.begin(), cells.end(), [](int n) { return n == 1; });
      };
      const auto top = [](std::uint32_t word, unsigned bits) { return bits == 0 ? 0U : word >> (32U - bits); };
      for (std::size_t d = 0; d < 4; ++d) CHECK(is_net([&](const auto& point) { return top(point[d], m); }));
      for (unsigned of_first = 0; of_first <= m; ++of_first)
        CHECK(is_net([&](const auto& point) {
          return top(point[0], of_first) << (m - of_first) | top(point[1], m - of_first);
        }));
    }
}

TEST_CASE("one point is uniform, and its places are independent of each other") {
  // Over replications: 16 × 16 cells for each pair of numbers of two places of one path, and of
  // neighbouring points of one sequence at different places. χ² each; the false-alarm rate of all
  // is 1e-6.
  constexpr int count = 1 << 16;
  constexpr std::size_t numbers = 12, pairs = numbers * (numbers - 1) / 2;
  const double alpha = gmis::sidak_level(1e-6, pairs);
  std::vector<std::vector<double>> observed(pairs, std::vector<double>(256, 0.0));
  for (int n = 0; n < count; ++n) {
    const auto run = static_cast<std::uint32_t>(n);
    const std::array<SampleNumbers::Block, 3> blocks{block_of(gmis_test::seed(4), run, 1, 5, 2),
                                                     block_of(gmis_test::seed(4), run, 1, 5, 2, 1),
                                                     block_of(gmis_test::seed(4), run, 1, 6, 3)};
    std::size_t pair = 0;
    for (std::size_t a = 0; a < numbers; ++a)
      for (std::size_t b = a + 1; b < numbers; ++b)
        ++observed[pair++][(blocks[a / 4][a % 4] >> 28U) << 4U | blocks[b / 4][b % 4] >> 28U];
  }
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    double chi_squared = 0.0;
    for (const double n : observed[pair]) chi_squared += (n - count / 256.0) * (n - count / 256.0) / (count / 256.0);
    CAPTURE(pair, chi_squared);
    CHECK(gmis::chi_square_p_value(chi_squared, 255) > alpha);
  }
}

namespace {

struct Moments {
  double mean = 0.0, variance = 0.0;
};

/// Mean and variance of the mean over `points` points, by independent replications: the integrand
/// is a product over the numbers of two vertices.
Moments mean_of_product(bool is_sobol, std::uint32_t points, int replications) {
  double sum = 0.0, squares = 0.0;
  for (int r = 0; r < replications; ++r) {
    double mean = 0.0;
    for (std::uint32_t i = 0; i < points; ++i) {
      const auto run = static_cast<std::uint32_t>(r);
      auto source = is_sobol ? SampleNumbers::sobol(gmis_test::seed(5), run, 9, 0, i, index_bits)
                             : SampleNumbers(gmis_test::seed(5), run, i, 0);
      double product = 1.0;
      for (const std::uint32_t vertex : {1U, 2U}) {
        source.at_vertex(vertex);
        for (const std::uint32_t word : source.next_block()) product *= 1.0 + 0.6 * (unit(word) - 0.5);
      }
      mean += product / points;
    }
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / replications;
  return {mean, (squares / replications - mean * mean) * replications / (replications - 1)};
}

}  // namespace

TEST_CASE("means are those of independent numbers, 1 here, with a fraction of the variance") {
  constexpr int replications = 400;
  const Moments sobol = mean_of_product(true, 256, replications);
  const Moments independent = mean_of_product(false, 256, replications);
  CHECK(gmis::z_test(sobol.mean, std::sqrt(sobol.variance / replications), 1.0).p_value > 1e-6);
  CHECK(gmis::z_test(independent.mean, std::sqrt(independent.variance / replications), 1.0).p_value > 1e-6);
  // Interactions of the two places remain; the rest is integrated nearly exactly. Closed form: (1 +
  // 0.03)^8 − 1 over 256 for independent numbers; what is left is at most that of interactions
  // between the places, ((1.03)^4 − 1)² over 256.
  const double all = std::pow(1.03, 8.0) - 1.0, between = std::pow(std::pow(1.03, 4.0) - 1.0, 2.0);
  const double spread = 1.0 + 6.0 * std::sqrt(2.0 / replications);
  CHECK(independent.variance * 256 < all * spread);
  CHECK(independent.variance * 256 > all / spread);
  CHECK(sobol.variance * 256 < 1.3 * between * spread);
}

TEST_CASE("the points are the same with every compiler and at every level of the processor") {
  std::uint64_t hash = 0;
  for (std::uint32_t i = 0; i < 1000; ++i)
    for (const std::uint32_t word : block_of(i / 7, i % 8, i, i * i, i % 5, static_cast<int>(i % 3)))
      hash = (hash ^ word) * 0x100000001B3U;
  CHECK(hash == 0x523A7A1871B260E5U);
}

TEST_CASE("when a sequence is used up another begins") {
  CHECK(block_of(1, 0, 0, (1U << index_bits) + 3, 1) != block_of(1, 0, 0, 3, 1));
  CHECK(block_of(1, gmis::sobol_replications, 0, 3, 1) == block_of(1, 0, 0, (1U << index_bits) + 3, 1));
}
