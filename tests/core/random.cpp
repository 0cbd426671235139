#include <array>
#include <cstdint>
#include <set>

#include "gmis/core/random.hpp"
#include "support/catch.hpp"

TEST_CASE("Philox4x32-10 gives the numbers that its authors publish") {
  // The known answers of Random123 (kat_vectors, philox4x32 with 10 rounds).
  using Block = std::array<std::uint32_t, 4>;
  constexpr std::uint32_t ones = 0xFFFFFFFFU;
  CHECK(gmis::philox4x32({0, 0, 0, 0}, {0, 0}) == Block{0x6627E8D5U, 0xE169C58DU, 0xBC57AC4CU, 0x9B00DBD8U});
  CHECK(gmis::philox4x32({ones, ones, ones, ones}, {ones, ones}) ==
        Block{0x408F276DU, 0x41C83B0EU, 0xA20BC7C6U, 0x6D5451FDU});
  CHECK(gmis::philox4x32({0x243F6A88U, 0x85A308D3U, 0x13198A2EU, 0x03707344U}, {0xA4093822U, 0x299F31D0U}) ==
        Block{0xD16CFE09U, 0x94FDCCEBU, 0x5001E420U, 0x24126EA1U});
}

TEST_CASE("seed, iteration, path, stream and vertex each lead to numbers of their own") {
  std::set<std::uint64_t> seen;
  int sources = 0;
  const auto look = [&](std::uint64_t seed, std::uint32_t iteration, std::uint32_t path, std::uint32_t stream,
                        std::uint32_t vertex) {
    gmis::Philox source(seed, iteration, path, stream);
    source.at_vertex(vertex);
    const std::uint64_t high = source();
    seen.insert(high << 32U | source());
    ++sources;
  };
  for (const std::uint64_t seed : {0ULL, 1ULL, 1ULL << 32U})
    for (std::uint32_t iteration = 0; iteration < 3; ++iteration)
      for (std::uint32_t path = 0; path < 3; ++path)
        for (std::uint32_t stream = 0; stream < 3; ++stream)
          for (const std::uint32_t vertex : {0U, 1U, 2U, 0xFFFFFFU}) look(seed, iteration, path, stream, vertex);
  CHECK(seen.size() == static_cast<std::size_t>(sources));  // 324 of 2^64: by chance alike once in 3e14
}

TEST_CASE("the numbers of a vertex do not depend on what was drawn before") {
  gmis::Philox source(7, 1, 2, 1);
  source.at_vertex(5);
  std::array<std::uint32_t, 9> first{};
  for (auto& word : first) word = source();
  source.at_vertex(6);
  CHECK(source() != first[0]);
  source.at_vertex(5);
  for (const std::uint32_t word : first) CHECK(source() == word);
  CHECK(std::set<std::uint32_t>(first.begin(), first.end()).size() == first.size());
}
