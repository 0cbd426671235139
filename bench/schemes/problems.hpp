#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "gmis/benchmark.hpp"
#include "gmis/core/random.hpp"
#include "gmis/mis/diagnostics/quadrature.hpp"

/// The integrals of the benchmarks. What the library and a loop by hand (own_loop/) have in common
/// is always inlined, so that their difference is the library and not what the compiler's inliner
/// thought of the one or the other.
namespace bench {

using Words = gmis::ComparisonSource;

/// The logistic density: exponential tails, so that every weight of a normal integrand is bounded
/// and all variances are finite. X is the type of a sample, D that of a density.
template <class X, class D = X>
struct Logistic {
  X centre, scale;
  template <class Source>
  [[gnu::always_inline]] X sample(Source& source) const {
    const X u = gmis::uniform<X>(source) + std::numeric_limits<X>::epsilon() / X(4);  // never 0
    return centre + scale * std::log(u / (X(1) - u + std::numeric_limits<X>::min()));
  }
  [[gnu::always_inline]] D pdf(X x) const {
    const D tail = std::exp(-std::abs(D(x) - D(centre)) / D(scale));
    return tail / (D(scale) * (D(1) + tail) * (D(1) + tail));
  }
};

/// N logistic proposals with centres spread evenly over ±spread, and a mean of three normals at
/// −spread, 0 and spread to integrate, so that I = 1. The wider, the less any single proposal
/// resembles the integrand.
struct Problem {
  const char* name;
  double spread;
  double scale;

  [[nodiscard]] std::vector<Logistic<double>> proposals(std::size_t n) const {
    std::vector<Logistic<double>> result(n);
    for (std::size_t k = 0; k < n; ++k) {
      const double place = n == 1 ? 0.5 : static_cast<double>(k) / static_cast<double>(n - 1);
      result[k] = {spread * (2.0 * place - 1.0), scale};
    }
    return result;
  }
  [[gnu::always_inline]] double operator()(double x) const {
    constexpr double peak = 0.3989422804014327 / 3.0;
    const double left = x + spread, right = x - spread;
    return peak * (std::exp(-0.5 * left * left) + std::exp(-0.5 * x * x) + std::exp(-0.5 * right * right));
  }
  [[nodiscard]] std::vector<gmis::QuadratureNode> nodes() const {
    const std::array<double, 2> ends{-spread - 12.0, spread + 12.0};
    return gmis::composite_gauss_legendre(ends, 24);
  }
};

inline constexpr std::array problems{Problem{"low", 0.5, 0.8}, Problem{"medium", 2.5, 0.8}, Problem{"high", 4.5, 0.8}};

}  // namespace bench
