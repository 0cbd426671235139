#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string_view>

#include "gmis/core/random.hpp"

namespace gmis {

/// The shift of the seeds of all tests: 0, or the value of the environment variable GMIS_TEST_SEED,
/// a number or `random`. The same value replays a run.
[[nodiscard]] inline std::uint64_t test_run_seed() {
  static const std::uint64_t value = [] {
    const char* const text = std::getenv("GMIS_TEST_SEED");
    if (text == nullptr || *text == '\0') return std::uint64_t{0};
    if (std::string_view(text) == "random") return std::uint64_t{std::random_device{}()};
    return static_cast<std::uint64_t>(std::strtoull(text, nullptr, 0));
  }();
  return value;
}

/// A source of random numbers for a test: seeded by `name`, so that no two tests share numbers, and
/// by `test_run_seed`.
[[nodiscard]] inline Philox seeded(std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;  // FNV-1a
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001B3ULL;
  return Philox(hash + test_run_seed() * 0x9E3779B97F4A7C15ULL);
}

}  // namespace gmis
