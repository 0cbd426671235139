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
#include "gmis/mis/batched_round.hpp"
#include "gmis/mis/location_scale.hpp"
#include "schemes/problems.hpp"

/// N3 by `estimate`, and by a loop that one would write for the same result: mean, variance between
/// rounds, and every sample checked (its own density, the mixture, f, f/φ). Both use the same
/// source, proposals and sums.
namespace own_loop {

struct Result {
  double mean, variance;
  std::uint64_t unusable;
};

[[gnu::always_inline]] inline double f(double x) {
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

/// The same proposals as a set of the library, each kind of number side by side.
template <class Shape, class P>
gmis::LocationScaleSet<Shape> side_by_side(std::span<const P> proposals) {
  std::vector<double> locations, scales;
  for (const P& proposal : proposals) {
    locations.push_back(proposal.centre);
    scales.push_back(proposal.scale);
  }
  return {locations, scales};
}

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
  const auto estimate = gmis::estimate<gmis::Scheme::N3>([](double x) { return f(x); }, set, rounds, source);
  return {estimate.mean, estimate.variance.value_or(0.0), estimate.rejected.total()};
}

template <class Set>
[[gnu::noinline]] Result in_batches(const Set& set, std::uint64_t rounds, std::uint64_t seed) {
  bench::Words source(seed);
  const auto estimate = gmis::estimate_in_batches([](double x) { return f(x); }, set, rounds, source);
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
