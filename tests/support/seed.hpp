#pragma once

#include <cstdint>

#include "gmis/testing/seeded.hpp"

namespace gmis_test {

/// The number that shifts the seeds of all property tests. A test that fails prints it
/// (support/main.cpp), and the same value replays the run.
inline std::uint64_t run_seed() {
  return gmis::test_run_seed();
}

/// The seed of one source of random inputs: `fixed`, unless the run asks for others.
inline std::uint64_t seed(std::uint64_t fixed) {
  return fixed + run_seed() * 0x9E3779B97F4A7C15ULL;
}

}  // namespace gmis_test
