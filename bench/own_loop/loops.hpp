#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "gmis/mis.hpp"
#include "schemes/problems.hpp"

/// N3 by `estimate`, and by a loop that one would write for the same result: mean, variance between rounds, and every sample
/// checked (its own density, the mixture, f, f/φ). Both use the same source, proposals and sums.
namespace own_loop {

struct Result {
  double mean, variance;
  std::uint64_t unusable;
};

inline double f(double x) {
  return std::exp(-0.5 * x * x) * 0.3989422804014327;
}

/// Heavy-tailed and without a call: its densities can be evaluated side by side.
struct Cauchy {
  double centre, scale;
  template <class Source>
  [[gnu::always_inline]] double sample(Source& source) const {
    return centre + scale * std::tan(std::numbers::pi * (gmis::uniform<double>(source) - 0.5));
  }
  [[gnu::always_inline]] double pdf(double x) const {
    const double z = (x - centre) / scale;
    return 1.0 / (std::numbers::pi * scale * (1.0 + z * z));
  }
};

/// The same proposals, each kind of number side by side: the loop over them in `pdfs` is compiled to vector instructions.
class SideBySide {
 public:
  using Value = double;
  using Density = double;
  static constexpr std::size_t capacity = 64;

  explicit SideBySide(std::span<const Cauchy> proposals) : size_(proposals.size()) {
    for (std::size_t i = 0; i < size_; ++i) {
      centre_[i] = proposals[i].centre;
      inverse_scale_[i] = 1.0 / proposals[i].scale;
      peak_[i] = 1.0 / (std::numbers::pi * proposals[i].scale);
    }
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[gnu::always_inline]] double sample(std::size_t i, gmis::UniformSource auto& source) const {
    return Cauchy{centre_[i], 1.0 / inverse_scale_[i]}.sample(source);
  }
  [[gnu::always_inline]] void pdfs(double x, std::span<double> out) const {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double z = (x - centre_[i]) * inverse_scale_[i];
      out[i] = peak_[i] / (1.0 + z * z);
    }
  }

 private:
  std::size_t size_;
  std::array<double, capacity> centre_{}, inverse_scale_{}, peak_{};
};

/// N of them, centres from −2 to 2.
template <class P>
std::vector<P> proposals(std::size_t n) {
  std::vector<P> result;
  for (std::size_t k = 0; k < n; ++k)
    result.push_back({n == 1 ? 0.0 : 4.0 * static_cast<double>(k) / static_cast<double>(n - 1) - 2.0, 0.9});
  return result;
}

template <class Set>
[[gnu::noinline]] Result by_library(const Set& set, std::uint64_t rounds, std::uint64_t seed) {
  bench::Words source(seed);
  const auto estimate = gmis::estimate<gmis::Scheme::N3>(f, set, rounds, source);
  return {estimate.mean, estimate.variance.value_or(0.0), estimate.rejected.total()};
}

/// `n` is a number, or an integral constant where N is known at compile time.
template <class P, class N>
[[gnu::noinline]] Result by_hand(const P* proposals, N n, std::uint64_t rounds, std::uint64_t seed) {
  bench::Words source(seed);
  gmis::Moments<double> moments;
  std::uint64_t unusable = 0;
  constexpr double largest = std::numeric_limits<double>::max();
  for (std::uint64_t round = 0; round < rounds; ++round) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = proposals[i].sample(source);
      double mixture = 0.0, own = 0.0, least = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        const double density = proposals[k].pdf(x);
        if (k == i) own = density;
        least = density < least ? density : least;
        mixture += density;
      }
      mixture /= static_cast<double>(static_cast<std::ptrdiff_t>(static_cast<std::size_t>(n)));
      const double value = f(x), contribution = value / mixture;
      if (own > 0.0 && least >= 0.0 && mixture <= largest && value - value == 0.0 && contribution - contribution == 0.0)
        sum += contribution;
      else
        ++unusable;
    }
    moments.add(sum / static_cast<double>(static_cast<std::ptrdiff_t>(static_cast<std::size_t>(n))));
  }
  return {moments.mean(), moments.variance(), unusable};
}

}  // namespace own_loop
