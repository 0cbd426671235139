#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "gmis/core/math.hpp"
#include "gmis/core/random.hpp"
#include "gmis/core/statistics.hpp"
#include "gmis/core/wyrand.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

using Counter = std::array<std::uint64_t, 2>;

TEST_CASE("Philox2x64-10 gives the numbers that its authors publish") {
  // The known answers of Random123 (kat_vectors, philox2x64 with 10 rounds).
  constexpr std::uint64_t ones = ~std::uint64_t{0};
  CHECK(gmis::philox2x64<10>({0, 0}, 0) == Counter{0xCA00A0459843D731U, 0x66C24222C9A845B5U});
  CHECK(gmis::philox2x64<10>({ones, ones}, ones) == Counter{0x65B021D60CD8310FU, 0x4D02F3222F86DF20U});
  CHECK(gmis::philox2x64<10>({0x243F6A8885A308D3U, 0x13198A2E03707344U}, 0xA4093822299F31D0U) ==
        Counter{0x0A5E742C2997341CU, 0xB0F883D38000DE5DU});
}

TEST_CASE("A 128-bit product is that of four 64-bit ones") {
  std::uint64_t a = gmis_test::seed(3), b = gmis_test::seed(4) | 1U;
  for (int n = 0; n < 1000; ++n) {
    const auto product = gmis::detail::multiply(a, b);
    constexpr std::uint64_t half = 0xFFFFFFFFU;
    const std::uint64_t a0 = a & half, a1 = a >> 32U, b0 = b & half, b1 = b >> 32U;
    const std::uint64_t middle = ((a0 * b0) >> 32U) + ((a1 * b0) & half) + ((a0 * b1) & half);
    CHECK(product.low == a * b);
    CHECK(product.high == a1 * b1 + ((a1 * b0) >> 32U) + ((a0 * b1) >> 32U) + (middle >> 32U));
    a = product.high * 0x9E3779B97F4A7C15U + product.low;
    b = product.low * 0xD2B74407B1CE6E93U ^ std::rotl(product.high, 17);
  }
}

TEMPLATE_TEST_CASE("seed, iteration, path, stream and vertex each lead to numbers of their own", "", gmis::Philox,
                   gmis::WyrandBlocks) {
  std::set<std::uint64_t> seen;
  int sources = 0;
  const auto look = [&](std::uint64_t seed, std::uint32_t iteration, std::uint32_t path, std::uint32_t stream,
                        std::uint32_t vertex) {
    TestType blocks(seed, iteration, path, stream);
    blocks.at_vertex(vertex);
    const auto block = blocks.next_block();
    seen.insert(std::uint64_t{block[0]} << 32U | block[1]);
    ++sources;
  };
  for (const std::uint64_t seed : {0ULL, 1ULL, 1ULL << 32U, 0xA0761D6478BD642FULL})
    for (std::uint32_t iteration = 0; iteration < 3; ++iteration)
      for (std::uint32_t path = 0; path < 3; ++path)
        for (std::uint32_t stream = 0; stream < 3; ++stream)
          for (const std::uint32_t vertex : {0U, 1U, 2U, 0xFFFFFFU}) look(seed, iteration, path, stream, vertex);
  CHECK(seen.size() == static_cast<std::size_t>(sources));  // 432 of 2^64: by chance alike once in 2e14
}

TEMPLATE_TEST_CASE("the numbers of a vertex do not depend on what was drawn before", "", gmis::Philox,
                   gmis::WyrandBlocks) {
  TestType source(7, 1, 2, 1);
  source.at_vertex(5);
  std::array<typename TestType::Block, 3> first{};
  for (auto& block : first) block = source.next_block();
  source.at_vertex(6);
  CHECK(source.next_block() != first[0]);
  source.at_vertex(5);
  std::set<std::uint32_t> words;
  for (const auto& block : first) {
    CHECK(source.next_block() == block);
    words.insert(block.begin(), block.end());
  }
  CHECK(words.size() == 12);
}

TEST_CASE("the numbers of different vertices of a path are far apart in the sequence of words") {
  // Vertex v + d begins n words after vertex v, for n · step = d · vertex_step modulo 2^64: n or −n
  // is never small.
  using Blocks = gmis::WyrandBlocks;
  std::uint64_t inverse = 1;  // of the step, by Newton's iteration
  for (int i = 0; i < 6; ++i) inverse *= 2 - Blocks::step * inverse;
  REQUIRE(inverse * Blocks::step == 1);
  std::uint64_t nearest = ~std::uint64_t{0}, words = 0;
  for (std::uint32_t d = 1; d < 1U << 24U; ++d) {
    words += Blocks::vertex_step * inverse;
    nearest = std::min({nearest, words, ~words + 1});
  }
  CHECK(nearest > std::uint64_t{1} << 32U);
}

TEST_CASE("the words are the same with every compiler") {
  std::uint64_t hash = 0;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    gmis::WyrandBlocks blocks(i / 7, i % 8, i, i % 3);
    blocks.at_vertex(i % 5);
    for (const auto& block : {blocks.next_block(), blocks.next_block()})
      for (const std::uint32_t word : block) hash = (hash ^ word) * 0x100000001B3U;
  }
  CHECK(hash == 0xD6FF10FED54CB63FU);
}

TEST_CASE("a block is the next words that nobody has begun to use") {
  gmis::Philox words(7, 1, 2, 1), blocks(7, 1, 2, 1);
  std::array<std::uint32_t, 12> expected{};
  for (auto& word : expected) word = words();
  const auto is_block = [&](const gmis::Philox::Block& block, std::size_t first) {
    return std::equal(block.begin(), block.end(), expected.begin() + static_cast<std::ptrdiff_t>(first));
  };
  CHECK(is_block(blocks.next_block(), 0));
  CHECK(blocks() == expected[4]);
  CHECK(is_block(blocks.next_block(), 8));

  gmis::Philox source(7, 1, 2, 1);
  const auto [a, b, c] = gmis::uniforms<float, 3>(source);
  CHECK(a == static_cast<float>(expected[0] >> 8U) * 0x1p-24F);
  CHECK(b == static_cast<float>(expected[1] >> 8U) * 0x1p-24F);
  CHECK(c == static_cast<float>(expected[2] >> 8U) * 0x1p-24F);
  CHECK(gmis::uniforms<float, 1>(source)[0] == static_cast<float>(expected[4] >> 8U) * 0x1p-24F);
  gmis::Philox one(3), other(3);
  const auto [x, y] = gmis::uniforms<double, 2>(one);
  CHECK(x == gmis::uniform<double>(other));
  CHECK(y == gmis::uniform<double>(other));
}

namespace {

constexpr double false_alarms = 1e-6;  // of each of the tests below

/// The stream of words that a path would see if only one part of the key moved.
enum class Moves { seed, iteration, path, vertex, block, seed_and_path };
constexpr std::array all_moves{Moves::seed,   Moves::iteration, Moves::path,
                               Moves::vertex, Moves::block,     Moves::seed_and_path};

template <class Blocks>
typename Blocks::Block block_at(Moves moves, std::uint32_t i, std::uint32_t base) {
  const auto at = [&](Moves part) { return moves == part ? base + i : base; };
  const bool both = moves == Moves::seed_and_path;
  Blocks source(both ? base + i : at(Moves::seed), at(Moves::iteration), both ? base - i : at(Moves::path), 1);
  source.at_vertex(moves == Moves::vertex ? (base + i) & 0xFFFFFFU : 5U);
  if (moves == Moves::block) {  // eight blocks a vertex
    source.at_vertex(i >> 3U);
    for (std::uint32_t skipped = 0; skipped < (i & 7U); ++skipped) static_cast<void>(source.next_block());
  }
  return source.next_block();
}

}  // namespace

TEMPLATE_TEST_CASE("whichever part of the key moves, numbers and pairs of numbers are uniform", "", gmis::Philox,
                   gmis::WyrandBlocks) {
  // Cells of 16 × 16 for each pair among the four numbers of a block and those of the block before
  // it: χ² each.
  constexpr std::uint32_t count = 1U << 17U;
  constexpr std::size_t cells = 256, numbers = 8, pairs = numbers * (numbers - 1) / 2;
  const double alpha = gmis::sidak_level(false_alarms, all_moves.size() * pairs);
  const auto base = static_cast<std::uint32_t>(gmis_test::seed(20));
  for (const Moves moves : all_moves) {
    std::array<std::vector<double>, pairs> observed;
    for (auto& table : observed) table.assign(cells, 0.0);
    auto before = block_at<TestType>(moves, 0, base);
    for (std::uint32_t i = 1; i <= count; ++i) {
      const auto now = block_at<TestType>(moves, i, base);
      const std::array<std::uint32_t, numbers> all{before[0], before[1], before[2], before[3],
                                                   now[0],    now[1],    now[2],    now[3]};
      std::size_t pair = 0;
      for (std::size_t a = 0; a < numbers; ++a)
        for (std::size_t b = a + 1; b < numbers; ++b) ++observed[pair++][(all[a] >> 28U) << 4U | all[b] >> 28U];
      before = now;
    }
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      double chi_squared = 0.0;
      const double expected = static_cast<double>(count) / cells;
      for (const double n : observed[pair]) chi_squared += (n - expected) * (n - expected) / expected;
      CAPTURE(static_cast<int>(moves), pair, chi_squared);
      CHECK(gmis::chi_square_p_value(chi_squared, cells - 1) > alpha);
    }
  }
}

namespace {

/// The words that a path would see if only one part of the key moved, one after the other.
template <class Blocks>
std::vector<std::uint32_t> words_of(Moves moves, std::size_t count, std::uint32_t base) {
  std::vector<std::uint32_t> words;
  for (std::uint32_t i = 0; words.size() < count; ++i) {
    const auto block = block_at<Blocks>(moves, i, base);
    words.insert(words.end(), block.begin(), block.end());
  }
  return words;
}

/// Probability of at most `count` events of a Poisson distribution with the mean `expected`: a
/// tail of χ².
double at_most(double count, double expected) {
  return gmis::chi_square_p_value(2.0 * expected, 2.0 * (count + 1.0));
}

/// The p-value of the test by birthday spacings [Marsaglia; L'Ecuyer and Simard 2001]: how often
/// two distances between 4096 neighbouring words are equal, over all groups of 4096 words. Each
/// group has a Poisson distribution with the mean 4096³ / (4 · 2^32) = 4.
double birthday_p_value(const std::vector<std::uint32_t>& words) {
  constexpr std::size_t birthdays = 4096;
  double equal = 0.0;
  for (std::size_t first = 0; first < words.size(); first += birthdays) {
    std::vector<std::uint32_t> days(words.begin() + static_cast<std::ptrdiff_t>(first),
                                    words.begin() + static_cast<std::ptrdiff_t>(first + birthdays));
    std::sort(days.begin(), days.end());
    for (std::size_t i = birthdays; --i > 0;) days[i] -= days[i - 1];
    std::sort(days.begin(), days.end());
    for (std::size_t i = 1; i < birthdays; ++i) equal += days[i] == days[i - 1] ? 1.0 : 0.0;
  }
  const double expected = 4.0 * static_cast<double>(words.size() / birthdays);
  return 2.0 * std::min(at_most(equal, expected), 1.0 - at_most(equal - 1.0, expected));
}

/// χ² of the ranks of 32 × 32 matrices of bits: 32, 31, or less.
double rank_p_value(const std::vector<std::uint32_t>& words) {
  constexpr std::array probabilities{0.2887880951, 0.5775761902, 0.1336357147};
  std::array<double, 3> observed{};
  for (std::size_t first = 0; first < words.size(); first += 32) {
    std::array<std::uint32_t, 32> rows{};
    std::copy_n(words.begin() + static_cast<std::ptrdiff_t>(first), 32, rows.begin());
    std::size_t rank = 0;
    for (std::uint32_t bit = 1; bit != 0; bit <<= 1U) {
      const auto pivot = std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(rank), rows.end(),
                                      [bit](std::uint32_t row) { return (row & bit) != 0; });
      if (pivot == rows.end()) continue;
      std::swap(*pivot, rows[rank]);
      for (std::size_t i = rank + 1; i < 32; ++i)
        if ((rows[i] & bit) != 0) rows[i] ^= rows[rank];
      ++rank;
    }
    ++observed[std::min<std::size_t>(32 - rank, 2)];
  }
  double chi_squared = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double expected = probabilities[i] * static_cast<double>(words.size() / 32);
    chi_squared += gmis::square(observed[i] - expected) / expected;
  }
  return gmis::chi_square_p_value(chi_squared, 2);
}

/// Correlation of the numbers of bits that are set in two words, `lag` apart: a sum of terms with
/// mean 0 and variance 1.
double weight_p_value(const std::vector<std::uint32_t>& words, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t i = lag; i < words.size(); ++i)
    sum += (std::popcount(words[i]) - 16) * (std::popcount(words[i - lag]) - 16) / 8.0;
  return gmis::z_test(sum, std::sqrt(static_cast<double>(words.size() - lag)), 0.0).p_value;
}

}  // namespace

TEMPLATE_TEST_CASE(
    "whichever part of the key moves, birthday spacings, ranks and weights are those of independent words", "",
    gmis::Philox, gmis::WyrandBlocks) {
  const double alpha = gmis::sidak_level(false_alarms, all_moves.size() * 4);
  const auto base = static_cast<std::uint32_t>(gmis_test::seed(23));
  for (const Moves moves : all_moves) {
    CAPTURE(static_cast<int>(moves));
    const auto words = words_of<TestType>(moves, std::size_t{1} << 20U, base);
    CHECK(birthday_p_value(words) > alpha);
    CHECK(rank_p_value(words) > alpha);
    CHECK(weight_p_value(words, 1) > alpha);
    CHECK(weight_p_value(words, 4) > alpha);
  }
}

namespace {

/// The largest distance, in standard deviations, of the number of changes of one of 128 bits from
/// half of the trials, where one of `bits` bits of the input changes. `change(bit)` makes an input
/// and returns the words before and after.
template <class Change>
double worst_bit(unsigned bits, int trials, Change&& change) {
  double worst = 0.0;
  for (unsigned bit = 0; bit < bits; ++bit) {
    std::array<int, 128> changes{};
    for (int n = 0; n < trials; ++n) {
      const auto [before, after] = change(bit);
      for (unsigned out = 0; out < 128; ++out)
        changes[out] += static_cast<int>(((before[out / 64] ^ after[out / 64]) >> (out % 64)) & 1U);
    }
    for (const int n : changes) worst = std::max(worst, std::abs(n - trials / 2) / (0.5 * std::sqrt(trials)));
  }
  return worst;
}

constexpr int trials = 1 << 14;

/// A binomial count of changes for every pair of bits, near the normal distribution.
double worst_by_chance(unsigned bits) {
  return gmis::normal_quantile(1.0 - 0.5 * gmis::sidak_level(false_alarms, std::size_t{bits} * 128));
}

}  // namespace

TEST_CASE("each bit of Philox's counter and key changes each bit of the numbers half of the time") {
  gmis::Philox inputs(gmis_test::seed(21));
  const auto word = [&inputs] { return std::uint64_t{inputs()} << 32U | inputs(); };
  const double worst = worst_bit(192, trials, [&](unsigned bit) {
    // Like the keys of a renderer: nearly all bits are 0.
    Counter counter{word() & word() & word() & 0xFFF0000007FU, word() & 0x0000003F00003FFFU};
    std::uint64_t key = word() & 0xFFU;
    const Counter before = gmis::philox2x64<7>(counter, key);
    (bit < 128 ? counter[bit / 64] : key) ^= std::uint64_t{1} << (bit % 64);
    return std::pair{before, gmis::philox2x64<7>(counter, key)};
  });
  CHECK(worst < worst_by_chance(192));
}

TEST_CASE("each bit of the key of wyrand's blocks changes each bit of the numbers half of the time") {
  gmis::Philox inputs(gmis_test::seed(22));
  constexpr unsigned bits = 64 + 32 + 32 + 8 + 24;
  const double worst = worst_bit(bits, trials, [&](unsigned bit) {
    // Like the keys of a renderer, but for a seed of any bits: there are too few keys with nearly
    // all bits 0.
    const std::uint64_t seed = std::uint64_t{inputs()} << 32U | inputs();
    const std::array<std::uint32_t, 4> rest{inputs() & 0x3FFU, inputs() & 0xFFFFFU, inputs() & 0x7U, inputs() & 0x1FU};
    const auto words_with = [&](bool changes) {
      const auto flip = [&](unsigned first, unsigned count) {
        return changes && bit >= first && bit < first + count ? std::uint64_t{1} << (bit - first) : 0;
      };
      gmis::WyrandBlocks blocks(seed ^ flip(0, 64), rest[0] ^ static_cast<std::uint32_t>(flip(64, 32)),
                                rest[1] ^ static_cast<std::uint32_t>(flip(96, 32)),
                                rest[2] ^ static_cast<std::uint32_t>(flip(128, 8)));
      blocks.at_vertex(rest[3] ^ static_cast<std::uint32_t>(flip(136, 24)));
      return blocks.next_words();
    };
    return std::pair{words_with(false), words_with(true)};
  });
  CHECK(worst < worst_by_chance(bits));
}
