#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "gmis/core/random.hpp"
#include "gmis/mis/diagnostics/quadrature.hpp"

/// Four integrals on which the methods of docs/mis-methods.md are compared. All densities are
/// sampled by inversion of their distribution, so that randomised quasi-Monte Carlo can be used
/// too.
namespace four {

/// Logistic density: exponential tails, which bound all weights of normal integrands. a: centre, b:
/// scale. Uniform on [a, b). Ramp: 1 + a (x − 1/2) on [0, 1), |a| < 2.
struct Density {
  enum class Kind : std::uint8_t { logistic, uniform, ramp } kind;
  double a = 0.0, b = 0.0;

  double sample(gmis::UniformSource auto& source) const {
    const double u = gmis::uniform<double>(source);
    switch (kind) {
      case Kind::logistic: {
        const double inside = u + 0x1p-54;  // never 0
        return a + b * std::log(inside / (1.0 - inside + 0x1p-60));
      }
      case Kind::uniform:
        return a + (b - a) * u;
      case Kind::ramp:
        break;
    }
    const double start = 1.0 - 0.5 * a;
    return 2.0 * u / (start + std::sqrt(start * start + 2.0 * a * u));
  }
  double pdf(double x) const {
    switch (kind) {
      case Kind::logistic: {
        const double tail = std::exp(-std::abs(x - a) / b);
        return tail / (b * (1.0 + tail) * (1.0 + tail));
      }
      case Kind::uniform:
        return x >= a && x < b ? 1.0 / (b - a) : 0.0;
      case Kind::ramp:
        break;
    }
    return x >= 0.0 && x < 1.0 ? 1.0 + a * (x - 0.5) : 0.0;
  }
};
inline Density logistic(double centre, double scale) {
  return {Density::Kind::logistic, centre, scale};
}
inline Density uniform(double low, double high) {
  return {Density::Kind::uniform, low, high};
}
inline Density ramp(double slope) {
  return {Density::Kind::ramp, slope, 0.0};
}

inline double normal(double x, double mean, double sd) {
  const double z = (x - mean) / sd;
  return std::exp(-0.5 * z * z) / (sd * std::sqrt(2.0 * std::numbers::pi));
}

struct Problem {
  const char* name;
  std::vector<Density> proposals;
  double (*f)(double);
  double integral;                  ///< in closed form
  std::vector<double> breakpoints;  ///< the ends, and every jump
  std::size_t panels;

  [[nodiscard]] std::vector<gmis::QuadratureNode> nodes() const {
    return gmis::composite_gauss_legendre(breakpoints, panels);
  }
  [[nodiscard]] std::vector<std::uint32_t> one_each() const { return std::vector<std::uint32_t>(proposals.size(), 1); }
};

/// Three modes, three proposals, each at one of them but too wide.
inline double modes(double x) {
  return (normal(x, -3.0, 0.7) + 2.0 * normal(x, 0.0, 0.7) + normal(x, 3.0, 0.7)) / 4.0;
}
/// A combination of the proposals with unequal coefficients.
inline double span(double x) {
  return 0.2 * logistic(-2.0, 0.8).pdf(x) + 0.7 * logistic(0.0, 0.5).pdf(x) + 0.1 * logistic(3.0, 1.0).pdf(x);
}
/// A smooth floor and a narrow highlight. Each proposal fits one of them; two of the four cover
/// only a part of the domain.
inline double highlight(double x) {
  return 0.5 + x + (x >= 0.6 && x < 0.64 ? 20.0 : 0.0);
}
/// Changes its sign; six proposals.
inline double waves(double x) {
  return std::exp(2.0 * x) * std::sin(7.0 * x) + 1.0;
}
/// ∫ over [0, 1] of e^(2x) sin 7x + 1.
inline double integral_of_waves() {
  return (std::exp(2.0) * (2.0 * std::sin(7.0) - 7.0 * std::cos(7.0)) + 7.0) / 53.0 + 1.0;
}

inline std::vector<Problem> problems() {
  return {
      {"modes", {logistic(-3.0, 0.8), logistic(0.0, 0.8), logistic(3.0, 0.8)}, modes, 1.0, {-45.0, 0.0, 45.0}, 64},
      {"span",
       {logistic(-2.0, 0.8), logistic(0.0, 0.5), logistic(3.0, 1.0)},
       span,
       1.0,
       {-45.0, -2.0, 0.0, 3.0, 60.0},
       48},
      {"highlight",
       {uniform(0.0, 1.0), uniform(0.55, 0.7), ramp(1.5), uniform(0.0, 0.5)},
       highlight,
       1.8,
       {0.0, 0.5, 0.55, 0.6, 0.64, 0.7, 1.0},
       4},
      {"waves",
       {ramp(1.5), uniform(0.2, 0.9), uniform(0.0, 0.4), uniform(0.3, 0.8), uniform(0.7, 1.0), uniform(0.0, 1.0)},
       waves,
       integral_of_waves(),
       {0.0, 0.2, 0.3, 0.4, 0.7, 0.8, 0.9, 1.0},
       4},
  };
}

}  // namespace four
