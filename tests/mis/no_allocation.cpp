#include <array>
#include <cstdlib>
#include <new>
#include <tuple>
#include <vector>

#include "gmis/mis.hpp"
#include "mis/proposals.hpp"
#include "support/catch.hpp"
#include "support/seed.hpp"

namespace {
std::size_t allocations = 0;
}

// Counts every allocation of this program. Not inlined, or the compiler takes malloc and free for a
// mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

TEST_CASE("estimates allocate nothing when N is known, and once when it is not", "[mis]") {
  const std::array<test::Ramp, 3> array{{{-1.0}, {0.3}, {1.5}}};
  const auto tuple = std::make_tuple(array[0], test::Uniform{});
  const std::vector<test::Ramp> vector(array.begin(), array.end());
  const auto f = [](double x) { return x; };
  double sink = 0.0;
  for (const auto selection : gmis::all_selections)
    for (const auto weighting : gmis::all_weightings) {
      CAPTURE(name_of(selection), name_of(weighting));
      gmis::Philox source(gmis_test::seed(1));
      const std::size_t before = allocations;
      sink += gmis::estimate(selection, weighting, f, array, 100, source).mean;
      sink += gmis::estimate(selection, weighting, f, tuple, 100, source).mean;
      const std::size_t with_known_size = allocations - before;
      sink += gmis::estimate(selection, weighting, f, vector, 100, source).mean;
      const std::size_t with_any_size = allocations - before - with_known_size;
      CHECK(with_known_size == 0);
      CHECK(with_any_size <= 3);  // the three arrays of the workspace, whatever the number of rounds
    }
  CHECK(sink > 0.0);
}

TEST_CASE("sums over few proposals allocate nothing, whatever is known of their number", "[mis]") {
  const auto f = [](double x) { return x; };
  for (const std::size_t n : {std::size_t{1}, std::size_t{2}, gmis::few_densities, gmis::few_densities + 1}) {
    const std::vector<test::Ramp> proposals(n, test::Ramp{0.5});
    for (const gmis::Scheme scheme : {gmis::Scheme::R3, gmis::Scheme::N3}) {
      CAPTURE(n, name_of(scheme));
      gmis::Philox source(gmis_test::seed(1));
      const std::size_t before = allocations;
      const double mean = gmis::estimate(scheme, f, proposals, 100, source).mean;
      CHECK((allocations - before == 0) == (n <= gmis::few_densities));
      CHECK(mean > 0.0);
    }
  }
}
