#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

namespace gmis_test {

/// What shifts the seeds of all property tests: 0, or what the environment variable GMIS_TEST_SEED says, a number or
/// `random`. A test that fails prints it (support/main.cpp), and the same value replays the run.
inline std::uint64_t run_seed() {
  static const std::uint64_t value = [] {
    const char* const text = std::getenv("GMIS_TEST_SEED");
    if (text == nullptr || *text == '\0') return std::uint64_t{0};
    if (std::string(text) == "random") return std::uint64_t{std::random_device{}()};
    return static_cast<std::uint64_t>(std::strtoull(text, nullptr, 0));
  }();
  return value;
}

/// The seed of one source of random inputs: `fixed`, unless the run asks for others.
inline std::uint64_t seed(std::uint64_t fixed) {
  return fixed + run_seed() * 0x9E3779B97F4A7C15ULL;
}

}  // namespace gmis_test
