#include <array>
#include <cmath>
#include <cstdio>
#include <gmis/mis.hpp>
#include <gmis/mis/diagnostics.hpp>
#include <numbers>
#include <random>

struct Normal {  // a proposal: anything with sample and pdf
  double mean, deviation;
  double sample(gmis::UniformSource auto& source) const {
    return std::normal_distribution<double>(mean, deviation)(source);
  }
  double pdf(double x) const {
    const double z = (x - mean) / deviation;
    return std::exp(-0.5 * z * z) / (deviation * std::sqrt(2.0 * std::numbers::pi));
  }
};

int main() {
  const std::array<Normal, 3> proposals{{{-3.0, 2.0}, {0.0, 2.0}, {3.0, 2.0}}};
  const auto f = [](double x) { return std::exp(-0.2 * x * x) * (1.0 + 0.5 * std::sin(3.0 * x)); };

  const std::array<double, 2> ends{-40.0, 40.0};
  const gmis::TabulatedProblem problem(f, proposals, gmis::composite_gauss_legendre(ends, 64));
  std::printf("integral by quadrature: %.6f\n\n", problem.integral());
  std::printf("scheme   estimate   std. error   variance of a round: exact   measured   densities per round\n");
  for (const gmis::Scheme scheme : gmis::all_schemes) {
    gmis::Philox source(1);  // any std random number engine will do
    const auto estimate = gmis::estimate(scheme, f, proposals, 100'000, source);
    std::printf("  %s    %9.6f   %10.6f   %26.6f   %8.6f   %19.2f\n", name_of(scheme).data(), estimate.mean,
                estimate.standard_error.value(), gmis::exact_variance(scheme, problem), estimate.variance.value(),
                static_cast<double>(estimate.density_evaluations) / static_cast<double>(estimate.rounds));
  }
}
