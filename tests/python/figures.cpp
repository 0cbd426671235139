// Prints figures of the MIS core, one `name value` a line, for mis_test.py to find again in Python.
// The integrand has no functions, only products and quotients: numpy computes the same bits.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "gmis/mis.hpp"
#include "gmis/mis/diagnostics.hpp"
#include "gmis/mis/location_scale.hpp"
#include "gmis/mis/methods.hpp"

namespace {

void print(const std::string& name, double value) {
  std::printf("%s %.17g\n", name.c_str(), value);
}

void print(const std::string& name, const gmis::Estimate<double>& estimate) {
  print(name + ".mean", estimate.mean);
  print(name + ".variance", estimate.variance.value());
  print(name + ".density_evaluations", static_cast<double>(estimate.density_evaluations));
}

}  // namespace

int main() {
  const std::array means{-3.0, 0.0, 3.0}, deviations{2.0, 2.0, 2.0};
  const gmis::LocationScaleSet<gmis::shapes::Normal> proposals(means, deviations);
  const auto f = [](double x) {
    const double bow = std::max(0.0, 1.0 - x * x / 16.0);
    return bow * bow * (5.0 + x);
  };
  const gmis::SampleAllocation<double> counts({3, 1, 2}), shares({0.5, 0.2, 0.3}, 7);
  const std::array ends{-4.0, 4.0};
  const std::vector<std::uint32_t> numbers{3, 1, 2};
  const gmis::TabulatedProblem problem(f, proposals, gmis::gauss_legendre_over_line(0.0, 3.0, 48, ends));
  for (const gmis::Scheme scheme : gmis::all_schemes) {
    const std::string name(gmis::name_of(scheme));
    gmis::Philox equal(5), with_counts(6), with_shares(7);
    print(name, gmis::estimate(scheme, f, proposals, 20'000, equal));
    print(name + ".counts", gmis::estimate(scheme, f, proposals, 20'000, with_counts, counts));
    print(name + ".shares", gmis::estimate(scheme, f, proposals, 20'000, with_shares, shares));
    print(name + ".exact", gmis::exact_variance(scheme, problem));
    print(name + ".exact_counts", gmis::exact_moments(scheme, counts, problem).variance);
    print(name + ".exact_shares", gmis::exact_moments(scheme, shares, problem).variance);
  }
  for (const gmis::Selection selection : gmis::all_selections)
    for (const gmis::Weighting weighting : gmis::all_weightings) {
      const std::string name = std::string(gmis::name_of(selection)) + std::string(gmis::name_of(weighting));
      gmis::Philox equal(5), with_counts(6);
      print(name, gmis::estimate(selection, weighting, f, proposals, 20'000, equal));
      print(name + ".counts", gmis::estimate(selection, weighting, f, proposals, 20'000, with_counts, counts));
    }
  gmis::Philox grouped(11);
  const gmis::Groups<> pairs(3, 2);
  print("groups", gmis::estimate_partial(f, proposals, pairs, 20'000, grouped));
  print("groups.exact", gmis::exact_moments(pairs, problem).variance);
  gmis::Philox power(8), cutoff(9), maximum(10);
  print("power", gmis::estimate_weighted(gmis::Power{1.5}, f, proposals, 20'000, power, counts));
  print("cutoff", gmis::estimate_weighted(gmis::Cutoff{0.3}, f, proposals, 20'000, cutoff, counts));
  print("maximum", gmis::estimate_weighted(gmis::Maximum{}, f, proposals, 20'000, maximum));
  print("power.exact",
        gmis::exact_moments_with_weights(gmis::RatioWeights<gmis::Power>{{1.5}}, numbers, problem).variance);
  print("integral", problem.integral());
  const auto fractions = gmis::optimal_fractions(problem);
  const auto best = gmis::optimal_counts(problem, 20);
  for (std::size_t i = 0; i < 3; ++i) {
    print("fraction" + std::to_string(i), fractions[i]);
    print("count" + std::to_string(i), best[i]);
  }
  return 0;
}
