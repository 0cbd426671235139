#include "gmis/result/counters.hpp"

#include <array>
#include <bit>

#include "support/catch.hpp"

// Every count there is, also one that is added to the struct later: nothing in here names one.

namespace {

using gmis::Counters;
using Numbers = std::array<std::uint64_t, sizeof(Counters) / sizeof(std::uint64_t)>;

/// Each count another number.
Counters numbered(std::uint64_t factor) {
  Numbers numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = factor * (i + 1);
  return std::bit_cast<Counters>(numbers);
}

}  // namespace

TEST_CASE("counts are added and taken away, each by itself") {
  Counters sum = numbered(1);
  sum += numbered(100);
  CHECK(std::bit_cast<Numbers>(sum) == std::bit_cast<Numbers>(numbered(101)));
  CHECK(std::bit_cast<Numbers>(sum - numbered(1)) == std::bit_cast<Numbers>(numbered(100)));
  CHECK(std::bit_cast<Numbers>(Counters()) == Numbers{});
}
