#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

/// \file
/// The common parts of fuzz targets: the bytes of an input taken one after the other, and a way to
/// report a condition that does not hold.

namespace fuzz {

/// Zeros after the last byte, so that every input is a whole one.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  [[nodiscard]] bool is_empty() const { return at_ >= size_; }
  [[nodiscard]] std::uint8_t byte() { return is_empty() ? std::uint8_t{0} : data_[at_++]; }
  [[nodiscard]] std::uint32_t below(std::uint32_t bound) { return byte() % bound; }
  [[nodiscard]] std::uint32_t word() {
    std::uint32_t word = 0;
    for (int i = 0; i < 4; ++i) word = (word << 8U) | byte();
    return word;
  }
  /// One of 256 numbers from `low` to `high`.
  [[nodiscard]] double between(double low, double high) { return low + (high - low) * byte() / 255.0; }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

/// Ends the program, for the fuzzer to keep the input.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

}  // namespace fuzz

/// The target; libFuzzer calls it, or replay.cpp.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
