#pragma once

#include <array>

#include "gmis/mis/diagnostics.hpp"
#include "mis/proposals.hpp"

/// The two cases with known variances: normal proposals, normal mixtures as integrands, ∫ f = 1, on
/// [−30, 30].
namespace test {

inline const std::array<Normal, 3> proposals_b{{{-3.0, 2.0}, {0.0, 2.0}, {3.0, 2.0}}};
inline double integrand_b(double x) {
  return (Normal{-3.0, 1.0}.pdf(x) + Normal{0.0, 1.0}.pdf(x) + Normal{3.0, 1.0}.pdf(x)) / 3.0;
}
inline const std::array<Normal, 2> proposals_d{{{-2.5, 2.0}, {2.5, 2.0}}};
inline double integrand_d(double x) {
  return 0.7 * Normal{-2.0, 1.0}.pdf(x) + 0.3 * Normal{3.0, 0.8}.pdf(x);
}

inline std::vector<gmis::QuadratureNode> oracle_nodes(std::size_t panels) {
  const std::array<double, 2> ends{-30.0, 30.0};
  return gmis::composite_gauss_legendre(ends, panels);
}
inline gmis::TabulatedProblem case_b(std::size_t panels = 64) {
  return {integrand_b, proposals_b, oracle_nodes(panels)};
}
inline gmis::TabulatedProblem case_d(std::size_t panels = 64) {
  return {integrand_d, proposals_d, oracle_nodes(panels)};
}

}  // namespace test
