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

TEST_CASE("without Sobol' points the numbers are those of Philox") {
  gmis::Philox philox(gmis_test::seed(1), 2, 3, 1);
  SampleNumbers numbers(gmis_test::seed(1), 2, 3, 1);
  for (const std::uint32_t vertex : {0U, 5U, 1U}) {
    philox.at_vertex(vertex);
    numbers.at_vertex(vertex);
    for (int i = 0; i < 6; ++i) CHECK(philox() == numbers());
    CHECK(philox.next_block() == numbers.next_block());
    CHECK(philox() == numbers());
  }
}

TEST_CASE("a scrambled bit depends on the bits above it alone, and half of the seeds flip it") {
  gmis::Philox source(gmis_test::seed(2));
  int flipped = 0;
  for (int n = 0; n < 4096; ++n) {
    const std::uint32_t x = source(), seed = source(), bit = source() % 32U;
    const std::uint32_t below = x ^ (std::uint32_t{1} << bit);  // as numbers with reversed bits
    const std::uint32_t difference = gmis::detail::laine_karras(x, seed) ^ gmis::detail::laine_karras(below, seed);
    CHECK(std::countr_zero(difference) == static_cast<int>(bit));
    flipped += static_cast<int>(((gmis::detail::laine_karras(x, seed) ^ x) >> bit) & 1U);
  }
  CHECK(std::abs(flipped - 2048) < 32 * gmis::normal_quantile(1.0 - 0.5e-6));
  CHECK(gmis::detail::reverse_bits(0x80000001U) == 0x80000001U);
  CHECK(gmis::detail::reverse_bits(0x12345678U) == 0x1E6A2C48U);
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
  // Over replications: 16 × 16 cells for each pair of numbers of two places of one path, and of neighbouring points of one
  // sequence at different places. χ² each; the false-alarm rate of all is 1e-6.
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

/// Of the mean over `points` points, by independent replications: a product over the numbers of two vertices.
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
  // Interactions of the two places remain; the rest is integrated nearly exactly. Closed form: (1 + 0.03)^8 − 1 over 256
  // for independent numbers; what is left is at most that of interactions between the places, ((1.03)^4 − 1)² over 256.
  const double all = std::pow(1.03, 8.0) - 1.0, between = std::pow(std::pow(1.03, 4.0) - 1.0, 2.0);
  const double spread = 1.0 + 6.0 * std::sqrt(2.0 / replications);
  CHECK(independent.variance * 256 < all * spread);
  CHECK(independent.variance * 256 > all / spread);
  CHECK(sobol.variance * 256 < 1.3 * between * spread);
}

TEST_CASE("when a sequence is used up another begins") {
  CHECK(block_of(1, 0, 0, (1U << index_bits) + 3, 1) != block_of(1, 0, 0, 3, 1));
  CHECK(block_of(1, gmis::sobol_replications, 0, 3, 1) == block_of(1, 0, 0, (1U << index_bits) + 3, 1));
}
