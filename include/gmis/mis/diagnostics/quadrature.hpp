#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <numbers>
#include <span>
#include <vector>

#include "gmis/core/argument_error.hpp"

namespace gmis {

/// One point of a quadrature rule: ∫ g ≈ Σ weight · g(x).
template <class X>
struct NodeAt {
  X x;            ///< where f is evaluated
  double weight;  ///< factor of f(x)
};
/// One point of a rule on the line.
using QuadratureNode = NodeAt<double>;

/// A quadrature rule: a range of nodes with a point `x` and a `weight`.
template <class R>
concept NodeRange = requires(const R& nodes) {
  std::size(nodes);
  std::begin(nodes)->x;
  { std::begin(nodes)->weight } -> std::convertible_to<double>;
};

/// The Gauss–Legendre rule with `count` points on [−1, 1], exact for polynomials of degree 2 count
/// − 1. The nodes are the roots of the Legendre polynomial, by Newton's method from the asymptotic
/// formula (Abramowitz, Stegun 22.16.6). Throws std::invalid_argument for no points.
[[nodiscard]] inline std::vector<QuadratureNode> gauss_legendre(std::size_t count) {
  require_argument(count > 0, "a quadrature rule of no points: ask for at least one");
  constexpr double pi = 3.14159265358979323846;
  std::vector<QuadratureNode> nodes(count);
  const double n = static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    double x = -std::cos(pi * (static_cast<double>(i) + 0.75) / (n + 0.5));
    double derivative = 0.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double previous = 1.0;
      double value = x;
      for (std::size_t degree = 2; degree <= count; ++degree) {
        const double d = static_cast<double>(degree);
        const double next = ((2.0 * d - 1.0) * x * value - (d - 1.0) * previous) / d;
        previous = value;
        value = next;
      }
      derivative = n * (x * value - previous) / (x * x - 1.0);
      const double step = value / derivative;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes[i] = {x, 2.0 / ((1.0 - x * x) * derivative * derivative)};
  }
  return nodes;
}

/// A composite Gauss–Legendre rule over the intervals between consecutive `breakpoints` (ascending:
/// the ends of the domain, and every place where an integrand or a density jumps), each cut into
/// `panels` equal parts of `order` points. Throws std::invalid_argument for fewer than two
/// breakpoints, for some that are not finite and ascending, for no panels and for no points.
[[nodiscard]] inline std::vector<QuadratureNode> composite_gauss_legendre(std::span<const double> breakpoints,
                                                                          std::size_t panels, std::size_t order = 16) {
  require_argument(breakpoints.size() >= 2, "a quadrature rule needs at least two breakpoints: the ends of the domain");
  require_argument(panels > 0, "a quadrature rule of no panels: ask for at least one");
  for (std::size_t i = 0; i < breakpoints.size(); ++i)
    require_argument(std::isfinite(breakpoints[i]) && (i == 0 || breakpoints[i - 1] < breakpoints[i]),
                     "breakpoints must be finite and ascending");
  const std::vector<QuadratureNode> reference = gauss_legendre(order);
  std::vector<QuadratureNode> nodes;
  nodes.reserve((breakpoints.size() - 1) * panels * order);
  for (std::size_t interval = 0; interval + 1 < breakpoints.size(); ++interval) {
    const double half_width = 0.5 * (breakpoints[interval + 1] - breakpoints[interval]) / static_cast<double>(panels);
    for (std::size_t panel = 0; panel < panels; ++panel) {
      const double centre = breakpoints[interval] + half_width * (2.0 * static_cast<double>(panel) + 1.0);
      for (const QuadratureNode& node : reference)
        nodes.push_back({centre + half_width * node.x, half_width * node.weight});
    }
  }
  return nodes;
}

/// A rule over the whole line, by the map x = centre + scale tan(π t/2) of a composite
/// Gauss–Legendre rule in t on (−1, 1): densities with tails down to 1/x² become smooth bounded
/// functions of t. `scale` is the width of the integrand. `breakpoints`: places, ascending,
/// where an integrand or a density jumps. Between two of them, and outside, lie `panels` equal
/// parts in t of `order` points. Throws std::invalid_argument for a scale that is not positive and
/// finite, and as `composite_gauss_legendre` does.
[[nodiscard]] inline std::vector<QuadratureNode> gauss_legendre_over_line(double centre, double scale,
                                                                          std::size_t panels,
                                                                          std::span<const double> breakpoints = {},
                                                                          std::size_t order = 16) {
  require_argument(std::isfinite(centre) && scale > 0.0 && std::isfinite(scale),
                   "a rule over the line needs a finite centre and a positive, finite scale");
  constexpr double half_pi = 0.5 * std::numbers::pi;
  std::vector<double> mapped{-1.0};
  for (const double x : breakpoints) mapped.push_back(std::atan((x - centre) / scale) / half_pi);
  mapped.push_back(1.0);
  std::vector<QuadratureNode> nodes = composite_gauss_legendre(mapped, panels, order);
  for (QuadratureNode& node : nodes) {
    const double tangent = std::tan(half_pi * node.x);
    node = {centre + scale * tangent, node.weight * scale * half_pi * (1.0 + tangent * tangent)};
  }
  return nodes;
}

/// The product of two rules on the line: a rule over the plane.
[[nodiscard]] inline std::vector<NodeAt<glm::dvec2>> tensor_rule(std::span<const QuadratureNode> x,
                                                                 std::span<const QuadratureNode> y) {
  std::vector<NodeAt<glm::dvec2>> nodes;
  nodes.reserve(x.size() * y.size());
  for (const QuadratureNode& a : x)
    for (const QuadratureNode& b : y) nodes.push_back({{a.x, b.x}, a.weight * b.weight});
  return nodes;
}
/// The product of three rules on the line: a rule over space.
[[nodiscard]] inline std::vector<NodeAt<glm::dvec3>> tensor_rule(std::span<const QuadratureNode> x,
                                                                 std::span<const QuadratureNode> y,
                                                                 std::span<const QuadratureNode> z) {
  std::vector<NodeAt<glm::dvec3>> nodes;
  nodes.reserve(x.size() * y.size() * z.size());
  for (const QuadratureNode& a : x)
    for (const QuadratureNode& b : y)
      for (const QuadratureNode& c : z) nodes.push_back({{a.x, b.x, c.x}, a.weight * b.weight * c.weight});
  return nodes;
}

}  // namespace gmis
