#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

// Selections as their definitions read.
namespace test {

/// S1: with replacement.
struct WithReplacement {
  std::size_t n;
  std::size_t sample_count() const { return n; }
  void next_probabilities(std::span<const std::uint32_t>, std::span<double> out) const {
    for (double& p : out) p = 1.0 / static_cast<double>(out.size());
  }
};
/// S2: without replacement.
struct WithoutReplacement {
  std::size_t n;
  std::size_t sample_count() const { return n; }
  void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
    for (double& p : out) p = 1.0 / static_cast<double>(out.size() - drawn.size());
    for (const std::uint32_t i : drawn) out[i] = 0.0;
  }
};
/// S3: in order.
struct InOrder {
  std::size_t n;
  std::size_t sample_count() const { return n; }
  void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = i == drawn.size() ? 1.0 : 0.0;
  }
};
/// In order from a random one on.
struct Cyclic {
  std::size_t n;
  std::size_t sample_count() const { return n; }
  void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const bool follows = !drawn.empty() && i == (drawn.back() + 1) % out.size();
      out[i] = drawn.empty() ? 1.0 / static_cast<double>(out.size()) : follows ? 1.0 : 0.0;
    }
  }
};
/// Two samples, the second rather of the same proposal; unequal marginals.
struct Sticky {
  std::size_t sample_count() const { return 2; }
  void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
    out[0] = 0.5, out[1] = 0.3, out[2] = 0.2;
    if (drawn.empty()) return;
    for (double& p : out) p *= 0.4;
    out[drawn.back()] += 0.6;
  }
};

}  // namespace test
