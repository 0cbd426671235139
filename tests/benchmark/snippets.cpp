#include <array>
#include <cmath>
#include <gmis/benchmark.hpp>
#include <gmis/mis.hpp>
#include <span>
#include <string>

#include "support/catch.hpp"

// The code of docs/time-your-scheme.md, verbatim, and checks that it does what the text says.

namespace {

struct Exponential {
  double rate;
  double sample(gmis::UniformSource auto& source) const {
    return -std::log(1.0 - gmis::uniform<double>(source)) / rate;
  }
  double pdf(double x) const { return x >= 0.0 ? rate * std::exp(-rate * x) : 0.0; }
};

struct Cyclic {  // in order, from a random proposal on
  std::size_t sample_count() const { return 3; }
  void next_probabilities(std::span<const std::uint32_t> drawn, std::span<double> out) const {
    for (double& p : out) p = drawn.empty() ? 1.0 / 3.0 : 0.0;
    if (!drawn.empty()) out[(drawn.back() + 1) % 3] = 1.0;
  }
};

std::string compare_my_schemes() {
  const std::array<Exponential, 3> proposals{{{0.5}, {1.0}, {1.5}}};
  const auto f = [](double x) { return x < 0.0 ? 0.0 : x * std::exp(-x); };
  const std::array<double, 1> jump{0.0};
  const gmis::ComparedProblem problem("x exp(-x)", f, proposals, gmis::gauss_legendre_over_line(0.0, 2.0, 32, jump));
  const auto antithetic = [&](gmis::UniformSource auto& source) {
    const double u = gmis::uniform<double>(source), x = -std::log(1.0 - u), y = -std::log(u + 1e-300);
    return (f(x) / proposals[1].pdf(x) + f(y) / proposals[1].pdf(y)) / 2.0;
  };
  auto contenders = problem.schemes();
  contenders.push_back(problem.selection("cyclic, W1", Cyclic{}, gmis::Weighting::W1));
  contenders.push_back({"antithetic", antithetic});
  return gmis::compare(problem, contenders).text();  // or .csv(), .json(), .gnuplot("errors.svg")
}

}  // namespace

TEST_CASE("the code of the page about timing", "[benchmark]") {
  const std::string text = compare_my_schemes();
  CAPTURE(text);
  CHECK(text.find("cyclic, W1") != std::string::npos);
  CHECK(text.find("antithetic") != std::string::npos);
}
